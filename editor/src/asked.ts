// When the view has come to rest, solids drawn from voxels get the colours that the server computes for the points that
// are seen: as fine as a picture of the command line.

import type { App } from './app';
import { Refusal } from './connection';
import type { Json, Packet } from './protocol';
import { bodyKey, isBounded, solidOf } from './store';
import { ColourSheet, type SeenPoints } from './view/asked';

const rest = 160;                   // ms without a change of the view until it rests
const most = 1 << 16;               // points in a request: others come between
const few = 1 << 13;                // of solids that take their time over each
const often = 120;                  // ms between pictures while colours arrive
/* The first answer for each pixel is for its middle; these follow, so that edges finer than a pixel become grey. */
const places = [[0, 0], [-0.375, 0.125], [0.125, 0.375], [0.375, -0.125], [-0.125, -0.375]] as const;

/* Functions that tell a surface's sides from one another. */
const turned = ['normal', 'view', 'light'];

/** How long the last picture took from its rest, for benchmarks: ms until every pixel had a colour, and all of them. */
export interface AskedTimes { first: number; whole: number; points: number; bytes: number }

/** Asks for the colours whenever the view rests. */
export function installAskedColours(app: App): AskedTimes {
  const times: AskedTimes = { first: 0, whole: 0, points: 0, bytes: 0 };
  const { store, viewport, connection } = app;
  let wanted: string | null = null, timer = 0, turn = 0;

  viewport.onDraw.push(() => {
    const seen = viewport.seen();
    if (seen === wanted) return;
    wanted = seen;
    clearTimeout(timer);
    if (seen !== null) timer = window.setTimeout(() => void ask(seen), rest);
  });

  /* The skin of what is gathered by rays: voxels lie within it, and colours differ on either side. */
  viewport.onView.push(() => {
    for (const body of viewport.voxelBodies()) if (isSlow(solidOf(store.state, body)?.json)) void askSkin(body);
  });

  async function askSkin(body: number): Promise<void> {
    const { view } = viewport, skin = view?.skinOf(body);
    if (!view || !skin) return;
    for (let first = 0; first < skin.vertices.length && viewport.view === view; first += few) {
      const end = Math.min(first + few, skin.vertices.length), part = (values: Float32Array) => values.subarray(3 * first, 3 * end);
      const answer = await colours(bodyKey(store.state, body), { points: part(skin.points), normals: part(skin.normals),
        views: part(skin.normals), footprints: new Float32Array(end - first) });
      if (!answer) return;
      view.colourSkin(body, skin.vertices.subarray(first, end), answer.arrays.colours as Uint8Array);
      viewport.invalidate();
    }
  }

  async function ask(seen: string): Promise<void> {
    const { width, height } = viewport.canvas, sheet = new ColourSheet(width, height), start = performance.now();
    const own = ++turn, fresh = (): boolean => own === turn && viewport.seen() === seen;
    let points = 0, bytes = 0;
    for (const [i, shift] of places.entries()) {
      for (const body of viewport.voxelBodies()) {
        if (!fresh()) return;
        const solid = solidOf(store.state, body)?.json, painted = solid?.kind === 'diffusion' && isBounded(store.state, body);
        const found = viewport.seePoints(body, followsSides(solid), painted, shift);
        const took = await takeAll(body, found, sheet, seen, fresh);
        if (took === null) return;
        points += found.pixels.length;
        bytes += took;
      }
      if (i === 0) times.first = performance.now() - start;
      viewport.showColours(sheet, seen, i === places.length - 1);
    }
    Object.assign(times, { whole: performance.now() - start, points, bytes });
  }

  /* The bytes that came and went; null when the view is another by now. */
  async function takeAll(body: number, found: SeenPoints, sheet: ColourSheet, seen: string,
    fresh: () => boolean): Promise<number | null> {
    let shown = performance.now(), bytes = 0;
    const step = isSlow(solidOf(store.state, body)?.json) ? few : most;
    for (let first = 0; first < found.pixels.length; first += step) {
      const end = Math.min(first + step, found.pixels.length);
      const part = (values: Float32Array | null): Float32Array | null => values && values.subarray(3 * first, 3 * end);
      const arrays: { [name: string]: Float32Array } = { points: part(found.points)!,
        footprints: found.footprints.subarray(first, end) };
      if (found.normals) Object.assign(arrays, { normals: part(found.normals), views: part(found.views) });
      const answer = await colours({ ...bodyKey(store.state, body), light: viewport.lightDirection }, arrays);
      if (!answer || !fresh()) return null;
      bytes += answer.bytes + Object.values(arrays).reduce((sum, values) => sum + values.byteLength, 0);
      sheet.take(found.pixels.subarray(first, end), answer.arrays.colours as Uint8Array);
      if (performance.now() - shown < often) continue;
      shown = performance.now();
      viewport.showColours(sheet, seen, false);
    }
    return bytes;
  }

  /* Null when it was refused: the solid is gone; the voxels stay then. One at a time, for a newer question would take the
     place of one that waits. */
  let last: Promise<unknown> = Promise.resolve();
  function colours(keys: Json, arrays: { [name: string]: Float32Array }): Promise<Packet | null> {
    const turn = last.then(() => askColours(keys, arrays));
    last = turn.catch(() => {});
    return turn;
  }

  async function askColours(keys: Json, arrays: { [name: string]: Float32Array }): Promise<Packet | null> {
    try {
      return await connection.upload<Packet>('colours', keys, arrays);
    } catch (reason) {
      if (!(reason instanceof Refusal)) throw reason;
      return null;
    }
  }
  return times;
}

/* Colours that flow are gathered by rays from every point. */
function isSlow(solid: Json | undefined): boolean { return solid?.kind === 'diffusion' || solid?.kind === 'combined'; }

/* On a surface that colours flow from the colour is that of the side. */
function followsSides(solid: Json | undefined): boolean {
  return isSlow(solid) || ((solid?.nodes ?? []) as Json[]).some((node) => turned.includes(node.function));
}
