// Colours that the server is asked for, point by point: of solids that are drawn from voxels while something moves, and
// that have more detail than voxels when it has come to rest.

import * as THREE from 'three';
import type { Shared } from './solids';

/** What is asked of the points that are seen: one pass over the view each. */
const passes = { points: 0, normals: 1, views: 2 } as const;

/** The points of a body that are seen, one for each pixel of `pixels`. */
export interface SeenPoints {
  pixels: Uint32Array;              // places in the picture, its lowest row first
  points: Float32Array;             // [·][3] material coordinates
  footprints: Float32Array;         // how wide a pixel is there, model units
  normals: Float32Array | null;     // [·][3], when they were wanted
  views: Float32Array | null;       // towards the eye
}

/** Draws where things are instead of how they look, and gathers it. */
export class PointPass {
  private target: THREE.WebGLRenderTarget | null = null;

  constructor(private readonly renderer: THREE.WebGLRenderer, private readonly shared: Shared) {}

  /** What of a body is seen in groups of parts; `turned`: with normals and views; `inside`: of sections alone. */
  see(body: number, groups: THREE.Object3D[], camera: THREE.Camera, turned: boolean, inside: boolean): SeenPoints {
    const { show } = this.shared, kept = show.value;
    if (inside) show.value = 1;
    const found = this.gather(body, groups, camera, turned);
    show.value = kept;
    return found;
  }

  private gather(body: number, groups: THREE.Object3D[], camera: THREE.Camera, turned: boolean): SeenPoints {
    const size = this.renderer.getDrawingBufferSize(new THREE.Vector2());
    if (this.target?.width !== size.x || this.target.height !== size.y) {
      this.target?.dispose();
      this.target = new THREE.WebGLRenderTarget(size.x, size.y, { type: THREE.FloatType, minFilter: THREE.NearestFilter,
        magFilter: THREE.NearestFilter });
    }
    const first = this.draw(passes.points, body, groups, camera);
    let count = 0;
    for (let i = 3; i < first.length; i += 4) if (first[i] > 0) ++count;
    const pixels = new Uint32Array(count), points = new Float32Array(3 * count), footprints = new Float32Array(count);
    for (let i = 0, k = 0; k < count; ++i) {
      if (!(first[4 * i + 3] > 0)) continue;
      pixels[k] = i;
      points.set(first.subarray(4 * i, 4 * i + 3), 3 * k);
      footprints[k++] = first[4 * i + 3];
    }
    const further = (what: number): Float32Array => {
      const all = this.draw(what, body, groups, camera), found = new Float32Array(3 * count);
      pixels.forEach((i, k) => found.set(all.subarray(4 * i, 4 * i + 3), 3 * k));
      return found;
    };
    return { pixels, points, footprints, normals: turned ? further(passes.normals) : null,
      views: turned ? further(passes.views) : null };
  }

  private draw(what: number, body: number, groups: THREE.Object3D[], camera: THREE.Camera): Float32Array {
    const { renderer, shared } = this, { width, height } = this.target!;
    shared.asking.value = body + 1;
    shared.askedFor.value = what;
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.autoClear = false;
    for (const group of groups) renderer.render(group, camera);
    renderer.autoClear = true;
    shared.asking.value = 0;
    const values = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(this.target!, 0, 0, width, height, values);
    renderer.setRenderTarget(null);
    return values;
  }
}

const steps = 4096;
const decoded = Float32Array.from({ length: 256 }, (_, i) =>
  (i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4));
const encoded = Uint8Array.from({ length: steps + 1 }, (_, i) =>
  Math.round(255 * (i / steps <= 0.0031308 ? (12.92 * i) / steps : 1.055 * (i / steps) ** (1 / 2.4) - 0.055)));

/** A picture of colours as the parts' shader takes it: one for each pixel of the view, its lowest row first; opacity 0
    where none is known. A pixel that is given several has their mean, of the light, not of the bytes. */
export class ColourSheet {
  readonly bytes: Uint8Array;
  readonly texture: THREE.DataTexture;
  private readonly sums: Float32Array;
  private readonly counts: Uint8Array;

  constructor(width: number, height: number) {
    this.bytes = new Uint8Array(4 * width * height);
    this.sums = new Float32Array(3 * width * height);
    this.counts = new Uint8Array(width * height);
    this.texture = new THREE.DataTexture(this.bytes, width, height, THREE.RGBAFormat);
    this.texture.minFilter = this.texture.magFilter = THREE.NearestFilter;
    this.texture.generateMipmaps = false;
  }

  /** Takes colours over; the next picture shows them. */
  take(pixels: Uint32Array, colours: Uint8Array): void {
    const { bytes, sums, counts } = this;
    for (let k = 0; k < pixels.length; ++k) {
      const pixel = pixels[k], count = ++counts[pixel];
      for (let c = 0; c < 3; ++c) {
        const sum = (sums[3 * pixel + c] += decoded[colours[4 * k + c]]);
        bytes[4 * pixel + c] = count === 1 ? colours[4 * k + c] : encoded[Math.round((steps * sum) / count)];
      }
      bytes[4 * pixel + 3] = 255;
    }
    this.texture.needsUpdate = true;
  }
}
