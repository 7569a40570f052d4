// The picture that curves are drawn over: fetched, laid into its pane, moved by its handles, asked for colours.

import type { Json, Packet } from '../protocol';
import { bodyJson } from '../store';
import type { Vec } from './curve';
import { turned, type PaneName } from './drawn';
import type { Session } from './session';

/** Where a picture lies, in model units; `tall` follows from the picture's shape. */
export interface Place { x: number; y: number; width: number; tall: number; turn: number }

const radians = Math.PI / 180;
const nobody = { path: '', image: null as HTMLCanvasElement | null, why: null as string | null };

export class ReferencePicture {
  private loaded = { ...nobody };
  private asked = '';

  constructor(private readonly session: Session, readonly pane: PaneName) {}

  /** What the document says of it; null when there is none. */
  get json(): Json | null {
    const { heldPicture, app } = this.session;
    if (heldPicture?.pane === this.pane) return heldPicture.value;
    return bodyJson(app.store.state).sketch?.[this.pane] ?? null;
  }

  /** The picture, once it is here; asks for it when the document names another. */
  get image(): HTMLCanvasElement | null {
    const path = this.json?.image as string | undefined;
    if (!path) return null;
    if (this.asked !== path && this.session.app.store.state.connection === 'open') void this.load(path);
    return this.loaded.path === path ? this.loaded.image : null;
  }

  /** Why it cannot be shown, a sentence; null when it can, or is on its way. */
  get why(): string | null { return this.loaded.path === this.json?.image ? this.loaded.why : null; }

  private async load(path: string): Promise<void> {
    this.asked = path;
    try {
      const { arrays } = await this.session.app.connection.ask<Packet>('image', { path });
      this.loaded = { path, why: null, image: await decoded(arrays.bytes as Uint8Array<ArrayBuffer>) };
    } catch (reason) {
      this.loaded = { path, image: null, why: (reason as Error).message };
    }
    this.session.tell();
  }

  get place(): Place | null {
    const { json, image } = this;
    if (!json || !image) return null;
    const width = json.width ?? 2;
    return { x: json.x ?? 0, y: json.y ?? 0, width, tall: (width * image.height) / image.width, turn: json.turn ?? 0 };
  }

  /** Its corners, counter-clockwise from the lower left, and the knob that turns it, `gap` above its upper edge. */
  handles(gap: number): { corners: Vec[]; knob: Vec; top: Vec } | null {
    const { place } = this;
    if (!place) return null;
    const { x, y, width, tall, turn } = place;
    const at = (u: number, v: number): Vec => {
      const [dx, dy] = turned([u, v], turn * radians);
      return [x + dx, y + dy];
    };
    return { corners: [at(-width / 2, -tall / 2), at(width / 2, -tall / 2), at(width / 2, tall / 2), at(-width / 2, tall / 2)],
      knob: at(0, tall / 2 + gap), top: at(0, tall / 2) };
  }

  /** Where a point of the pane lies on it, 0..1 from its upper left corner; null beside it. */
  private share(x: number, y: number): Vec | null {
    const { place } = this;
    if (!place) return null;
    const [u, v] = turned([x - place.x, y - place.y], -place.turn * radians);
    const share: Vec = [u / place.width + 0.5, 0.5 - v / place.tall];
    return share.every((each) => each >= 0 && each < 1) ? share : null;
  }

  has(x: number, y: number): boolean { return this.share(x, y) !== null; }

  /** The colour under a point of the pane, the mean of a few pixels; null beside the picture. */
  colourAt(x: number, y: number): string | null {
    const { image } = this, share = this.share(x, y);
    if (!image || !share) return null;
    const left = Math.max(0, Math.min(image.width - 3, Math.floor(share[0] * image.width) - 1));
    const top = Math.max(0, Math.min(image.height - 3, Math.floor(share[1] * image.height) - 1));
    const { data } = image.getContext('2d', { willReadFrequently: true })!.getImageData(left, top, 3, 3), sum = [0, 0, 0];
    let weight = 0;
    for (let i = 0; i < data.length; i += 4) {
      for (let c = 0; c < 3; ++c) sum[c] += data[i + c] * data[i + 3];
      weight += data[i + 3];
    }
    if (weight === 0) return null;
    return `#${sum.map((value) => Math.round(value / weight).toString(16).padStart(2, '0')).join('')}`;
  }
}

/* As large as a screen at most: more is not seen, and takes long to draw. */
async function decoded(bytes: Uint8Array<ArrayBuffer>): Promise<HTMLCanvasElement> {
  const bitmap = await createImageBitmap(new Blob([bytes]));
  const scale = Math.min(1, 2048 / Math.max(bitmap.width, bitmap.height));
  const canvas = document.createElement('canvas');
  canvas.width = Math.max(1, Math.round(bitmap.width * scale));
  canvas.height = Math.max(1, Math.round(bitmap.height * scale));
  const brush = canvas.getContext('2d', { willReadFrequently: true })!;
  brush.imageSmoothingQuality = 'high';
  brush.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  return canvas;
}
