// Packets of the protocol, small ones: a round mesh, its halves as parts, an exemplar of a recipe's colours.

import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

const arrayTypes = { f32: Float32Array, u32: Uint32Array, i16: Int16Array, u16: Uint16Array, i8: Int8Array, u8: Uint8Array };

/** A packet of a text and arrays, each `[type, numbers]`. */
export function packet(head, arrays) {
  const parts = [], places = {};
  let at = 0;
  for (const [name, [type, numbers]] of Object.entries(arrays)) {
    const typed = numbers instanceof Uint8Array ? numbers : arrayTypes[type].from(numbers);
    const bytes = Buffer.from(typed.buffer, typed.byteOffset, typed.byteLength), room = Math.ceil(bytes.length / 4) * 4;
    places[name] = [at, type, typed.length];
    parts.push(bytes, Buffer.alloc(room - bytes.length));
    at += room;
  }
  let text = JSON.stringify({ ...head, arrays: places });
  text += ' '.repeat((4 - (Buffer.byteLength(text) % 4)) % 4);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(Buffer.byteLength(text));
  return Buffer.concat([length, Buffer.from(text), ...parts]);
}

/* A unit sphere as a grid of longitudes and latitudes, drawn out along z. */
const rows = 24, columns = 36, tall = 1.25;
const positions = [], triangles = [];
for (let i = 0; i <= rows; ++i) {
  for (let j = 0; j < columns; ++j) {
    const polar = (Math.PI * i) / rows, round = (2 * Math.PI * j) / columns;
    positions.push(Math.sin(polar) * Math.cos(round), Math.sin(polar) * Math.sin(round), tall * Math.cos(polar));
  }
}
for (let i = 0; i < rows; ++i) {
  for (let j = 0; j < columns; ++j) {
    const a = i * columns + j, b = i * columns + ((j + 1) % columns), c = a + columns, d = b + columns;
    if (i > 0) triangles.push(a, c, b);
    if (i < rows - 1) triangles.push(b, c, d);
  }
}

export function sphereMesh(body, serial) {
  return packet({ kind: 'mesh', body, serial, closed: true, report: { triangles: triangles.length / 3 }, box: [[-1 + 2.4 * body, -1, -tall], [1 + 2.4 * body, 1, tall]] },
    { positions: ['f32', positions.map((x, i) => (i % 3 === 0 ? x + 2.4 * body : x))], triangles: ['u32', triangles], painted: ['f32', Array(triangles.length / 3).fill(0)] });
}

/** A solid baked into a grid: shells of green and white. */
export function ballSolid(body, serial) {
  const n = 24, voxels = new Uint8Array(4 * n ** 3);
  for (let i = 0; i < n ** 3; ++i) {
    const [x, y, z] = [i % n, Math.floor(i / n) % n, Math.floor(i / n / n)].map((at) => (2 * at) / (n - 1) - 1), away = Math.hypot(x, y, z);
    voxels.set(away > 0.95 ? [107, 80, 48, 255] : away > 0.4 ? [134, 171, 44, 255] : [241, 238, 210, 255], 4 * i);
  }
  return packet({ kind: 'solid', body, serial, type: 'grid', size: [n, n, n], origin: [2.4 * body - 1, -1, -tall], spacing: [2 / (n - 1), 2 / (n - 1), (2 * tall) / (n - 1)] },
    { voxels: ['u8', voxels] });
}

/** The layer of a depth: the sphere, smaller. */
export function sphereLayer({ id, depth }) {
  const size = 1 - depth;
  return packet({ kind: 'layer', id, depth, range: [0, 1] }, { positions: ['f32', positions.map((x) => x * size)], normals: ['f32', positions], triangles: ['u32', triangles] });
}

/** Streamlines from pole to pole. */
export function meridians({ id }) {
  const points = [], start = [0];
  for (let j = 0; j < columns; j += 3) {
    for (let i = 1; i < rows; ++i) { const v = 3 * (i * columns + j); points.push(...positions.slice(v, v + 3).map((x) => 1.01 * x)); }
    start.push(points.length / 3);
  }
  return packet({ kind: 'lines', id }, { positions: ['f32', points], start: ['u32', start], depth: ['f32', Array(points.length / 3).fill(0.2)], part: ['u32', Array(start.length - 1).fill(0)] });
}

/* A plane beyond everything that keeps what lies beyond it. */
const leavesNothing = ({ plane, keep }) => keep === 'positive' && plane?.point.some((x) => x > 50);

/** Two halves of every body while there are cuts that keep both sides, else one part of each. */
export function sphereView(document, revision, serial) {
  const bodies = document.bodies ?? [document], halves = (document.cuts ?? []).some((cut) => (cut.keep ?? 'both') === 'both') ? 2 : 1;
  const parts = [], points = [], corners = [], normals = [], faces = [];
  if (!(document.cuts ?? []).some(leavesNothing)) bodies.forEach((_, body) => {
    for (let half = 0; half < halves; ++half) {
      const first = corners.length / 3, base = points.length / 3;
      positions.forEach((x, i) => points.push(i % 3 === 0 ? x + 2.4 * body : x));
      for (let t = 0; t < triangles.length / 3; ++t) {
        const own = triangles.slice(3 * t, 3 * t + 3), upper = own.reduce((sum, v) => sum + positions[3 * v + 2], 0) > 0;
        if (halves === 2 && upper !== (half === 0)) continue;
        corners.push(...own.map((v) => v + base));
        faces.push(t);
        for (const v of own) normals.push(...octahedral(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2] / tall ** 2));
      }
      const inside = [2.4 * body, 0, halves === 2 ? 0.5 - half : 0];
      const known = (document.parts ?? []).find((each) => each.at.every((x, i) => x === inside[i]));
      parts.push({ body, offset: [0, 0, halves === 2 ? 0.1 - 0.2 * half : 0], hidden: known?.hidden ?? false, inside,
                   triangles: [first, corners.length / 3 - first], vertices: [base, positions.length / 3] });
    }
  });
  const count = corners.length / 3;
  return packet({ kind: 'view', revision, serial, parts, depth: true, seconds: { cut: 0.0041, pack: 0.002 }, box: [[-1, -1, -1.35], [1 + 2.4 * (bodies.length - 1), 1, 1.35]] }, {
    positions: ['f32', points], depth: ['u16', Array(points.length / 3).fill(2000)], corners: ['u32', corners], normals: ['i16', normals],
    kinds: ['u8', Array(count).fill(0)], faces: ['u32', faces], layer_start: ['u32', Array(count + 1).fill(0)], layers: ['u32', []],
  });
}

function octahedral(x, y, z) {
  const size = Math.abs(x) + Math.abs(y) + Math.abs(z);
  let [u, v] = [x / size, y / size];
  if (z < 0) [u, v] = [(1 - Math.abs(v)) * (Math.sign(u) || 1), (1 - Math.abs(u)) * (Math.sign(v) || 1)];
  return [Math.round(32767 * u), Math.round(32767 * v)];
}

/** An exemplar's voxels: the recipe's stops along s, with a little grain. */
export function voxelsOf(request, document, root) {
  const exemplar = request.exemplar ?? (document.bodies ?? [document])[0].solids[0].exemplar;
  const shipped = exemplar.recipe && join(root, 'examples', exemplar.recipe);
  const recipe = exemplar.layered ?? (existsSync(shipped) ? JSON.parse(readFileSync(shipped)) : {});
  const size = [32, 32, 32], voxels = new Uint8Array(4 * 32 ** 3);
  const stops = recipe.stops?.length ? recipe.stops : [{ depth: 0, colour: '#808080' }];
  for (let t = 0, at = 0; t < 32; ++t) {
    for (let s = 0; s < 32; ++s) {
      const stop = stops.findLast((each) => (each.depth ?? 0) <= s / 31) ?? stops[0];
      for (let r = 0; r < 32; ++r, at += 4) {
        const grain = 0.88 + 0.12 * Math.sin(r * 1.3 + s * 0.7 + t * 2.1);
        for (let c = 0; c < 3; ++c) voxels[at + c] = parseInt(stop.colour.slice(1 + 2 * c, 3 + 2 * c), 16) * grain;
        voxels[at + 3] = 255;
      }
    }
  }
  return packet({ kind: 'exemplar', id: request.id, size, channels: 4, wraps: [true, false, true] }, { voxels: ['u8', voxels] });
}
