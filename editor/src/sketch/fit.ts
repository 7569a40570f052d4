// A hand's stroke becomes a curve: a few points through which a spline runs that stays within a tolerance of it.

import { distance, Spline, type Knot, type Vec } from './curve';

/** Lengths in the units of the stroke. */
export interface Fitting {
  pixel: number;                    // what a hand can aim at: strokes are even to within it
  half: boolean;                    // a vertical curve, which stays right of the axis
}

const mostKnots = 64;

/** Do a stroke's ends meet, so that it is a loop? */
export function isLoop(stroke: readonly Vec[], near: number): boolean {
  const ends = distance(...stroke[0], ...stroke[stroke.length - 1]), length = lengthOf(stroke);
  return ends < near && length > 5 * near;
}

function lengthOf(line: readonly Vec[]): number {
  return line.reduce((sum, point, i) => (i > 0 ? sum + distance(...point, ...line[i - 1]) : 0), 0);
}

/** The knots of a curve along a stroke. The hand's tremble is taken out first; sharp bends become corners. Knots are added
    in the middle of the stretch that is farthest off, until all are within 1.5 pixels. */
export function fitStroke(stroke: readonly Vec[], closed: boolean, { pixel, half }: Fitting): Knot[] {
  const even = evenly(stroke, closed, 2 * pixel), corners = cornersOf(even, closed), line = calm(even, closed, corners);
  const n = line.length;
  if (n < 3) return line.map(([x, y]) => ({ x, y, corner: false }));
  let marks = new Set<number>(closed ? [0, Math.floor(n / 4), Math.floor(n / 2), Math.floor((3 * n) / 4)] : [0, n - 1]);
  for (const corner of corners) marks.add(corner);
  for (;;) {
    const at = [...marks].sort((a, b) => a - b), knots = at.map((i) => knot(line[i], corners.has(i)));
    const worst = worstStretch(line, at, new Spline(knots, closed, half), closed);
    if (!worst || worst.off <= 1.5 * pixel || at.length >= mostKnots) return knots;
    marks = marks.add(worst.middle);
  }
}

const knot = ([x, y]: Vec, corner: boolean): Knot => ({ x, y, corner });

/* The stretch between two neighbouring marks whose points lie farthest from the spline; null when none can be divided. */
function worstStretch(line: readonly Vec[], at: number[], spline: Spline, closed: boolean):
  { off: number; middle: number } | null {
  let found: { off: number; middle: number } | null = null;
  const n = line.length;
  at.forEach((from, piece) => {
    const to = piece + 1 < at.length ? at[piece + 1] : closed ? at[0] + n : from;
    if (to - from < 2) return;
    const drawn = Array.from({ length: 25 }, (_, k) => spline.at(piece, k / 24));
    let off = 0;
    for (let i = from + 1; i < to; ++i) {
      const [x, y] = line[i % n];
      off = Math.max(off, awayFrom(drawn, x, y));
    }
    if (!found || off > found.off) found = { off, middle: Math.round((from + to) / 2) % n };
  });
  return found;
}

function awayFrom(line: readonly Vec[], x: number, y: number): number {
  let best = Infinity;
  for (let j = 0; j + 1 < line.length; ++j) {
    const [ax, ay] = line[j], [bx, by] = line[j + 1], dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
    const along = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
    best = Math.min(best, distance(x, y, ax + along * dx, ay + along * dy));
  }
  return best;
}

/* The stroke at even steps. The first point of a loop is not given again. */
function evenly(stroke: readonly Vec[], closed: boolean, step: number): Vec[] {
  const whole = closed ? [...stroke, stroke[0]] : stroke, length = lengthOf(whole);
  const count = Math.max(closed ? 8 : 2, Math.round(length / step)), made: Vec[] = [];
  let segment = 0, before = 0;
  for (let i = 0; i < (closed ? count : count + 1); ++i) {
    const want = (length * i) / count;
    let own = 0;
    for (; segment + 1 < whole.length; ++segment) {
      own = distance(...whole[segment], ...whole[segment + 1]);
      if (before + own >= want || segment + 2 === whole.length) break;
      before += own;
    }
    const [ax, ay] = whole[segment], [bx, by] = whole[segment + 1], t = own > 0 ? Math.min(1, (want - before) / own) : 0;
    made.push([ax + t * (bx - ax), ay + t * (by - ay)]);
  }
  return made;
}

/* Where the stroke turns by more than 60 degrees within a few steps, and most of all thereabouts. */
function cornersOf(line: readonly Vec[], closed: boolean): Set<number> {
  const n = line.length, reach = 5, least = Math.PI / 3;
  const at = (i: number): Vec => line[((i % n) + n) % n];
  const turn = (i: number): number => {
    if (!closed && (i < reach || i >= n - reach)) return 0;
    const [x, y] = at(i), [ax, ay] = at(i - reach), [bx, by] = at(i + reach);
    const angle = Math.atan2(by - y, bx - x) - Math.atan2(y - ay, x - ax);
    return Math.abs(angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI)));
  };
  const turns = line.map((_, i) => turn(i)), found = new Set<number>();
  if (n < 4 * reach) return found;
  turns.forEach((here, i) => {
    if (here < least) return;
    for (let k = -reach; k <= reach; ++k) {
      const other = turns[(((i + k) % n) + n) % n];
      if (other > here || (other === here && k < 0)) return;
    }
    found.add(i);
  });
  return found;
}

/* The line without its tremble: each point the mean of those about it, by a bell curve; ends and corners stay. */
function calm(line: readonly Vec[], closed: boolean, corners: Set<number>): Vec[] {
  const n = line.length, wide = 4, weights = Array.from({ length: wide + 1 }, (_, k) => Math.exp(-0.5 * (k / 1.8) ** 2));
  const stop = (i: number): boolean => corners.has(i) || (!closed && (i <= 0 || i >= n - 1));
  return line.map((point, i) => {
    if (stop(i)) return point;
    let reach = 0;                  // as far to both sides as no end or corner stands between
    while (reach < wide && !stop((i + reach + n) % n) && !stop((i - reach + n) % n)) ++reach;
    let sum = weights[0], x = weights[0] * point[0], y = weights[0] * point[1];
    for (let k = 1; k <= reach; ++k) {
      for (const [u, v] of [line[(i + k) % n], line[(i - k + n) % n]]) {
        sum += weights[k];
        x += weights[k] * u;
        y += weights[k] * v;
      }
    }
    return [x / sum, y / sum];
  });
}

/** Knots whose numbers are no finer than a tenth of a pixel. */
export function tidy(knots: Knot[], pixel: number): Knot[] {
  const digits = Math.min(9, Math.max(0, Math.ceil(-Math.log10(pixel / 5))));
  const round = (value: number): number => Number(value.toFixed(digits));
  const made = knots.map(({ x, y, corner }) => ({ x: round(x), y: round(y), corner }));
  return made.filter(({ x, y }, i) => i === 0 || x !== made[i - 1].x || y !== made[i - 1].y);
}

/** Knots of a vertical curve brought to the right of the axis: ends within `snap` of it onto it, what runs along it there
    left out, all else a little off it. From the upper end to the lower one. */
export function toHalfPlane(knots: Knot[], closed: boolean, snap: number, least: number): Knot[] {
  const made = knots.map((each) => ({ ...each }));
  if (closed) return made.map((each) => ({ ...each, x: Math.max(each.x, least) }));
  const onAxis = (each: Knot): boolean => each.x <= snap;
  if (made.length > 1 && made[0].y < made[made.length - 1].y) made.reverse();
  const first = onAxis(made[0]), last = onAxis(made[made.length - 1]);
  while (first && made.length > 2 && made[1].x <= 0) made.shift();
  while (last && made.length > 2 && made[made.length - 2].x <= 0) made.pop();
  return made.map((each, i) => {
    const end = (i === 0 && first) || (i === made.length - 1 && last);
    return { ...each, x: end ? 0 : Math.max(each.x, least) };
  });
}
