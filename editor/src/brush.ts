// Which vertices a brush meets: what the library's pith_brush_mark says (src/sketch/brush.c), for showing a stroke while
// it is drawn.

import type { Point } from './protocol';

export interface Brush { radius: number; repeat: 'once' | 'folds' | 'around'; folds: number }

/* The distance, squared, of a place from the straight line between two others. */
function squareToSegment(a: Point, b: Point, x: number, y: number, z: number): number {
  const u = b[0] - a[0], v = b[1] - a[1], w = b[2] - a[2], px = x - a[0], py = y - a[1], pz = z - a[2];
  const whole = u * u + v * v + w * w;
  const t = whole > 0 ? Math.min(1, Math.max(0, (px * u + py * v + pz * w) / whole)) : 0;
  return (px - t * u) ** 2 + (py - t * v) ** 2 + (pz - t * w) ** 2;
}

/** Calls `met` for the vertices that lie within the brush between two points of it, or of its copies round the z axis;
    all are where they were drawn. Gives how many there were. */
export function meetVertices(drawn: ArrayLike<number>, from: Point, to: Point, brush: Brush,
  met: (vertex: number) => void): number {
  const { radius, repeat, folds } = brush, reach = radius * radius, around = repeat === 'around';
  const flat = ([x, y, z]: Point): Point => (around ? [Math.hypot(x, y), 0, z] : [x, y, z]);
  const a = flat(from), b = flat(to), copies = repeat === 'folds' && folds > 1 ? folds : 1;
  const low = a.map((each, k) => Math.min(each, b[k]) - radius), high = a.map((each, k) => Math.max(each, b[k]) + radius);
  let count = 0;
  for (let copy = 0; copy < copies; ++copy) {
    const angle = (2 * Math.PI * copy) / copies, c = Math.cos(angle), s = Math.sin(angle);
    for (let v = 0; 3 * v < drawn.length; ++v) {
      const z = drawn[3 * v + 2];
      if (z < low[2] || z > high[2]) continue;
      const px = drawn[3 * v], py = drawn[3 * v + 1];
      const x = around ? Math.hypot(px, py) : c * px + s * py, y = around ? 0 : c * py - s * px;
      if (x < low[0] || x > high[0] || y < low[1] || y > high[1]) continue;
      if (squareToSegment(a, b, x, y, z) > reach) continue;
      ++count;
      met(v);
    }
  }
  return count;
}

/** On which side of a stroke over the picture a place lies: right of it as it runs, or left. It goes on straight beyond
    its ends. */
export function sideOfStroke(stroke: { x: number; y: number }[], x: number, y: number): 'right' | 'left' {
  let best = Infinity, right = false;
  for (let i = 0; i + 1 < stroke.length; ++i) {
    const a = stroke[i], b = stroke[i + 1], dx = b.x - a.x, dy = b.y - a.y, whole = dx * dx + dy * dy;
    if (whole === 0) continue;
    let t = ((x - a.x) * dx + (y - a.y) * dy) / whole;
    if (i > 0) t = Math.max(0, t);
    if (i + 2 < stroke.length) t = Math.min(1, t);
    const off = Math.hypot(x - a.x - t * dx, y - a.y - t * dy), cross = dx * (y - a.y) - dy * (x - a.x);
    // At a corner both neighbours are as near; the one that sees the place more from the side decides.
    const slant = off > 0 ? Math.abs(cross) / (Math.sqrt(whole) * off) : 1, near = off + 1e-3 * (1 - slant) * (1 + off);
    if (near >= best) continue;
    best = near;
    right = cross > 0; // y goes down on the screen
  }
  return right ? 'right' : 'left';
}
