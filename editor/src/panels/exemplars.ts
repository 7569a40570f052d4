// Exemplars as people see them: a name, a cube, and those a document knows.

import type { App } from '../app';
import type { Json } from '../protocol';
import type { Voxels } from '../model';
import { h } from '../ui/dom';

/** What an exemplar is called: its file's name, or that its recipe stands in the document. */
export function exemplarName(exemplar: Json | undefined): string {
  const path = (exemplar?.recipe ?? exemplar?.file) as string | undefined;
  if (path) return path.split('/').pop()!.replace(/\.(json|nrrd)$/, '').replaceAll('_', ' ');
  return exemplar?.layered ? 'recipe in the document' : 'none';
}

/** All exemplars a document names, each once, in the order they stand. */
export function exemplarsOf(document: Json): Json[] {
  const found = new Map<string, Json>();
  for (const body of document.bodies ?? [document]) {
    for (const solid of body.solids ?? []) {
      for (const each of [solid, ...(solid.pastes ?? [])]) {
        if (each.exemplar) found.set(JSON.stringify(each.exemplar), each.exemplar);
      }
    }
  }
  return [...found.values()];
}

/** What a texture type looks like: a photograph, over a pattern where there is none; the type's word is on it. */
export function typePicture(type: string, look: string): HTMLElement {
  const made = h('span', { class: look, 'data-type': type }, h('span', { class: 'type-word' }, type));
  const image = h('img', { src: `types/${type}.jpg`, alt: '', onload: () => made.prepend(image) });
  return made;
}

/** Keeps a canvas showing an exemplar as a cube, three of its faces seen; asks the server when `keys` change. */
export class Cube {
  readonly canvas = document.createElement('canvas');
  /** The voxels shown last; null before. */
  voxels: Voxels | null = null;
  private shown = '';

  constructor(private readonly app: App, size: number) {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    this.canvas.width = this.canvas.height = Math.round(size * ratio);
    this.canvas.style.width = this.canvas.style.height = `${size}px`;
    this.canvas.className = 'cube';
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', 'Exemplar');
  }

  /** Shows the exemplar of a request, when it is another than the one shown. Returns a sentence when it is refused. */
  async show(keys: Json, of: unknown): Promise<string | null> {
    const text = JSON.stringify([keys, of]);
    if (text === this.shown) return null;
    this.shown = text;
    this.canvas.classList.add('waiting');
    try {
      const voxels = await this.app.model.exemplar(keys);
      if (text !== this.shown) return null;
      this.voxels = voxels;
      drawCube(this.canvas, voxels);
      return null;
    } catch (reason) {
      if (text === this.shown) this.shown = '';
      return (reason as Error).message;
    } finally {
      this.canvas.classList.remove('waiting');
    }
  }
}

/* Three faces in parallel projection: r to the right, t to the back, s (inwards) down. What is seen through shows what
   lies behind it. */
function drawCube(canvas: HTMLCanvasElement, { size: [nr, ns, nt], voxels }: Voxels): void {
  const brush = canvas.getContext('2d')!, side = canvas.width, u = side * 0.46, v = side * 0.255, high = side * 0.44;
  const at = (r: number, s: number, t: number): number => 4 * (r + nr * (s + ns * t));
  brush.setTransform(1, 0, 0, 1, 0, 0);
  brush.clearRect(0, 0, side, side);
  const middle = side / 2, top = side * 0.03;
  // Upper face: s = 0, seen from outside. Left: t = last, r against s. Right: r = last, t against s.
  const upper = { wide: nr, high: nt, deep: ns, at: (x: number, y: number, z: number) => at(x, z, y) };
  const left = { wide: nr, high: ns, deep: nt, at: (x: number, y: number, z: number) => at(x, y, nt - 1 - z) };
  const right = { wide: nt, high: ns, deep: nr,
    at: (x: number, y: number, z: number) => at(nr - 1 - z, y, nt - 1 - x) };
  drawFace(brush, upper, [u, v, -u, v, middle, top], 1, voxels);
  drawFace(brush, left, [u, v, 0, high, middle - u, top + v], 0.8, voxels);
  drawFace(brush, right, [u, -v, 0, high, middle, top + 2 * v], 0.62, voxels);
}

/* A side of the box, and the voxels behind each of its pixels. */
interface Face { wide: number; high: number; deep: number; at(x: number, y: number, z: number): number }

/* One face, as an image on a parallelogram: two edges and the corner they start from. */
function drawFace(brush: CanvasRenderingContext2D, face: Face, [ax, ay, bx, by, ox, oy]: number[], light: number,
  voxels: Uint8Array): void {
  const { wide, high } = face, image = new ImageData(wide, high);
  for (let i = 0; i < wide * high; ++i) {
    image.data.set(seenAt(face, i % wide, Math.floor(i / wide), light, voxels), 4 * i);
  }
  const sheet = document.createElement('canvas');
  sheet.width = wide;
  sheet.height = high;
  sheet.getContext('2d')!.putImageData(image, 0, 0);
  brush.setTransform(ax / wide, ay / wide, bx / high, by / high, ox, oy);
  brush.imageSmoothingQuality = 'high';
  brush.drawImage(sheet, 0, 0);
  brush.setTransform(1, 0, 0, 1, 0, 0);
  brush.strokeStyle = 'rgb(128 128 128 / 0.35)';
  brush.beginPath();
  brush.moveTo(ox, oy);
  brush.lineTo(ox + ax, oy + ay);
  brush.lineTo(ox + ax + bx, oy + ay + by);
  brush.lineTo(ox + bx, oy + by);
  brush.closePath();
  brush.stroke();
}

/* What is seen through a pixel of a face: its voxels laid over one another until nothing shines through. */
function seenAt(face: Face, x: number, y: number, light: number, voxels: Uint8Array): number[] {
  const seen = [0, 0, 0];
  let through = 1;
  for (let z = 0; z < face.deep && through > 0.01; ++z) {
    const from = face.at(x, y, z), share = (through * voxels[from + 3]) / 255;
    for (let c = 0; c < 3; ++c) seen[c] += share * voxels[from + c];
    through -= share;
  }
  const covered = 1 - through;
  return [...seen.map((sum) => (covered > 0 ? (light * sum) / covered : 0)), 255 * covered];
}
