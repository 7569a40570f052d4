// Curves of a sketch as the library draws them (pith/sketch.h): smooth through their points, with corners at points that
// are given twice.

export type Vec = [x: number, y: number];

/** A point that a curve runs through; a corner is written twice. */
export interface Knot { x: number; y: number; corner: boolean }

export const distance = (ax: number, ay: number, bx: number, by: number): number => Math.hypot(ax - bx, ay - by);

/** The knots of a document's points. */
export function knotsOf(points: Vec[], closed: boolean): Knot[] {
  const knots: Knot[] = [];
  for (const [x, y] of points) {
    const last = knots[knots.length - 1];
    if (last && last.x === x && last.y === y) last.corner = true;
    else knots.push({ x, y, corner: false });
  }
  const first = knots[0], last = knots[knots.length - 1];
  if (closed && knots.length > 1 && first.x === last.x && first.y === last.y) {
    first.corner = true;
    knots.pop();
  }
  return knots;
}

/** The points a document writes for knots. */
export function pointsOf(knots: Knot[]): Vec[] {
  return knots.flatMap(({ x, y, corner }) => (corner ? [[x, y], [x, y]] as Vec[] : [[x, y] as Vec]));
}

/** A place on a curve: at `t` of a piece, 0..1. */
export interface Place { piece: number; t: number; x: number; y: number; distance: number; length: number }

const fine = 20;                    // segments of the line that stands for a piece

/** Cubic pieces between knots, with steps of the parameter that are roots of the distances (centripetal Catmull and Rom
    splines). Of a vertical curve, `half`, ends on the axis meet it at a right angle, and nothing comes left of it. */
export class Spline {
  readonly line: Vec[] = [];
  readonly lengths: number[] = [];  // along the line
  private readonly leave: Vec[] = [];
  private readonly arrive: Vec[] = [];
  private readonly steps: number[] = [];

  constructor(readonly knots: readonly Knot[], readonly closed: boolean, half = false) {
    this.findDerivatives(half);
    if (half) this.keepRight();
    for (let i = 0; i < this.pieces; ++i) for (let k = 0; k < fine; ++k) this.line.push(this.at(i, k / fine));
    const last = knots[closed ? 0 : knots.length - 1];
    if (last) this.line.push([last.x, last.y]);
    let sum = 0;
    this.line.forEach(([x, y], i) => {
      if (i > 0) sum += distance(x, y, ...this.line[i - 1]);
      this.lengths.push(sum);
    });
  }

  get pieces(): number { return this.closed ? this.knots.length : Math.max(0, this.knots.length - 1); }
  get length(): number { return this.lengths[this.lengths.length - 1] ?? 0; }

  private next(i: number): number { return (i + 1) % this.knots.length; }

  private chord(i: number): Vec {
    const a = this.knots[i], b = this.knots[this.next(i)];
    return [(b.x - a.x) / this.steps[i], (b.y - a.y) / this.steps[i]];
  }

  private findDerivatives(half: boolean): void {
    const { knots, closed, pieces } = this, n = knots.length;
    for (let i = 0; i < pieces; ++i) {
      const a = knots[i], b = knots[this.next(i)];
      this.steps.push(Math.sqrt(distance(a.x, a.y, b.x, b.y)) || 1e-9);
    }
    const isEnd = (i: number): boolean => !closed && (i === 0 || i === n - 1);
    for (let i = 0; i < n; ++i) {
      this.leave[i] = this.arrive[i] = [0, 0];
      if (knots[i].corner || isEnd(i)) continue;
      const before = i === 0 ? pieces - 1 : i - 1, share = this.steps[i] / (this.steps[before] + this.steps[i]);
      const a = this.chord(i), b = this.chord(before);
      this.leave[i] = this.arrive[i] = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
    }
    const onAxis = (i: number): boolean => half && !closed && pieces > 0 && knots[i].x === 0 && !knots[i].corner;
    const above = onAxis(0), below = onAxis(n - 1);
    if (above) this.leave[0] = [this.chord(0)[0], 0];
    if (below) this.arrive[n - 1] = [this.chord(pieces - 1)[0], 0];
    const beyond = (chord: Vec, other: Vec): Vec => [2 * chord[0] - other[0], 2 * chord[1] - other[1]];
    for (let i = 0; i < pieces; ++i) {
      const j = this.next(i), chord = this.chord(i);
      const fromFree = (knots[i].corner || isEnd(i)) && !(i === 0 && above);
      const toFree = (knots[j].corner || isEnd(j)) && !(j === n - 1 && below);
      if (fromFree) this.leave[i] = toFree ? chord : beyond(chord, this.arrive[j]);
      if (toFree) this.arrive[j] = fromFree ? chord : beyond(chord, this.leave[i]);
    }
  }

  /* A cubic stays right of the axis when its four control points do. */
  private keepRight(): void {
    const { knots, closed, steps, pieces } = this, n = knots.length;
    for (let i = 0; i < n && pieces > 0; ++i) {
      const first = !closed && i === 0, last = !closed && i === n - 1;
      const low = last ? -Infinity : (-3 * knots[i].x) / steps[i];
      const high = first ? Infinity : (3 * knots[i].x) / steps[i === 0 ? pieces - 1 : i - 1];
      this.leave[i] = [Math.max(this.leave[i][0], low), this.leave[i][1]];
      this.arrive[i] = [Math.min(this.arrive[i][0], high), this.arrive[i][1]];
      if (knots[i].corner || first || last) continue;
      this.leave[i] = this.arrive[i] = [Math.min(this.leave[i][0], high), this.leave[i][1]];
    }
  }

  at(piece: number, t: number): Vec {
    const a = this.knots[piece], b = this.knots[this.next(piece)], h = this.steps[piece];
    const u = this.leave[piece], v = this.arrive[this.next(piece)], t2 = t * t, t3 = t2 * t;
    const p = 2 * t3 - 3 * t2 + 1, q = (t3 - 2 * t2 + t) * h, r = 3 * t2 - 2 * t3, s = (t3 - t2) * h;
    return [p * a.x + q * u[0] + r * b.x + s * v[0], p * a.y + q * u[1] + r * b.y + s * v[1]];
  }

  /** The place nearest to a point. */
  nearest(x: number, y: number): Place {
    const best: Place = { piece: 0, t: 0, x: NaN, y: NaN, distance: Infinity, length: 0 };
    for (let j = 0; j + 1 < this.line.length; ++j) {
      const [ax, ay] = this.line[j], [bx, by] = this.line[j + 1], dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
      const along = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
      const away = distance(x, y, ax + along * dx, ay + along * dy);
      if (!(away < best.distance)) continue;
      const piece = Math.floor(j / fine), t = (j % fine + along) / fine;
      Object.assign(best, { piece, t, distance: away, length: this.lengths[j] + along * Math.sqrt(square) });
    }
    if (best.distance < Infinity) [best.x, best.y] = this.at(best.piece, best.t);
    return best;
  }

  /** How far along the curve a knot is. */
  lengthAt(knot: number): number { return this.lengths[Math.min(knot * fine, this.lengths.length - 1)] ?? 0; }

  /** The stretch of the line within `reach` of a length along it, to both sides; all of a closed one that it goes round. */
  stretch(from: number, reach: number): Vec[] {
    const { line, lengths, length } = this;
    if (this.closed && 2 * reach >= length) return line;
    const away = (at: number): number => {
      const gap = Math.abs(at - from);
      return this.closed ? Math.min(gap, length - gap) : gap;
    };
    const first = this.closed ? lengths.findIndex((at) => away(at) > reach) : 0, found: Vec[] = [];
    for (let k = 0; k < line.length; ++k) {
      const i = (first + k) % line.length;
      if (away(lengths[i]) <= reach) found.push(line[i]);
    }
    return found;
  }
}

/** Twice the area a closed line encloses, positive when it runs counter-clockwise. */
export function area2(line: readonly Vec[]): number {
  return line.reduce((sum, [x, y], i) => {
    const [u, v] = line[(i + 1) % line.length];
    return sum + x * v - y * u;
  }, 0);
}

/** Is a point inside a closed line? */
export function isInside(line: readonly Vec[], x: number, y: number): boolean {
  let inside = false;
  for (let i = 0, j = line.length - 1; i < line.length; j = i++) {
    const [ax, ay] = line[i], [bx, by] = line[j];
    if ((ay > y) !== (by > y) && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  }
  return inside;
}

/** Is a point right of an open line as it runs, which goes on straight beyond its ends? Of a closed one: outside. */
export function isPositive(line: readonly Vec[], closed: boolean, x: number, y: number): boolean {
  if (closed) return !isInside(line, x, y);
  let best = Infinity, right = false;
  const last = line.length - 2;
  for (let i = 0; i <= last; ++i) {
    const [ax, ay] = line[i], [bx, by] = line[i + 1], dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
    if (!(square > 0)) continue;
    const share = ((x - ax) * dx + (y - ay) * dy) / square;
    const along = Math.min(i === last ? Infinity : 1, Math.max(i === 0 ? -Infinity : 0, share));
    const away = distance(x, y, ax + along * dx, ay + along * dy);
    if (!(away < best - 1e-12)) continue;
    best = away;
    right = dx * (y - ay) - dy * (x - ax) < 0;
    // At a corner between two segments the sign of either may be wrong; that of the corner's turn is right.
    if (along === 1 && share > 1 && i < last) {
      const [cx, cy] = line[i + 2], turn = dx * (cy - by) - dy * (cx - bx);
      if (turn !== 0) right = turn > 0;
    }
  }
  return right;
}
