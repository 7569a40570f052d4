// What a drag or a brush does to a curve, for the hand that holds it to see: the server does the same to the document.

import { distance, type Knot } from './curve';

/* ---- bending ------------------------------------------------------------------------------------------------------- */

/* A complex number of the banded systems. */
class Complex {
  constructor(readonly re: number, readonly im: number) {}
  add(b: Complex): Complex { return new Complex(this.re + b.re, this.im + b.im); }
  sub(b: Complex): Complex { return new Complex(this.re - b.re, this.im - b.im); }
  mul(b: Complex): Complex { return new Complex(this.re * b.re - this.im * b.im, this.re * b.im + this.im * b.re); }
  scale(k: number): Complex { return new Complex(this.re * k, this.im * k); }
  conj(): Complex { return new Complex(this.re, -this.im); }
  get abs(): number { return Math.hypot(this.re, this.im); }
}
const zero = new Complex(0, 0);

/** A curve dragged at a knot as rigidly as possible (Igarashi, Moscovich and Hughes 2005): first each knot keeps its place
    in the frame of its neighbours, then segments get their lengths back. Knots farther along than `reach` stay. */
export function bend(knots: readonly Knot[], closed: boolean, grabbed: number, x: number, y: number, reach: number): Knot[] {
  const n = knots.length, made = knots.map((knot) => ({ ...knot }));
  const move = new Complex(x - knots[grabbed].x, y - knots[grabbed].y);
  const most = closed ? [n - 1, n - 1] : [grabbed, n - 1 - grabbed];
  let [before, after] = most.map((limit, side) => within(knots, grabbed, side === 0 ? -1 : 1, limit, reach));
  let stay = [Math.min(2, most[0] - before), Math.min(2, most[1] - after)];
  if (closed && before + after >= n - 1) [before, after, stay] = [0, n - 1, [0, 0]];
  if (stay[0] + stay[1] === 0) return made.map((knot) => ({ ...knot, x: knot.x + move.re, y: knot.y + move.im }));
  const handle = before + stay[0], count = handle + 1 + after + stay[1];
  const index = Array.from({ length: count }, (_, i) => (((grabbed + i - handle) % n) + n) % n);
  const drag = new Drag(index.map((i) => new Complex(knots[i].x, knots[i].y)),
    index.map((_, i) => i === handle || i < stay[0] || i >= count - stay[1]), handle, move);
  drag.keepAngles();
  drag.keepLengths();
  index.forEach((i, k) => {
    if (drag.fixed[k] && k !== handle) return;
    made[i].x = k === handle ? x : knots[i].x + drag.shift[k].re;
    made[i].y = k === handle ? y : knots[i].y + drag.shift[k].im;
  });
  return made;
}

/* How many knots to one side are within reach. */
function within(knots: readonly Knot[], from: number, step: 1 | -1, most: number, reach: number): number {
  const n = knots.length;
  let length = 0;
  for (let i = 1; i <= most; ++i) {
    const a = knots[(from + step * (i - 1) + n * i) % n], b = knots[(from + step * i + n * i) % n];
    length += distance(a.x, a.y, b.x, b.y);
    if (length > reach) return i - 1;
  }
  return most;
}

/* Least squares for how far the knots move; some of them are given. */
class Drag {
  shift: Complex[];
  private readonly unit: number;    // length of what moves and what holds it
  private band: Complex[][] = [];
  private right: Complex[] = [];

  constructor(private readonly rest: Complex[], readonly fixed: boolean[], handle: number, move: Complex) {
    this.shift = rest.map((_, i) => (i === handle ? move : zero));
    this.unit = rest.slice(1).reduce((sum, point, i) => sum + point.sub(rest[i]).abs, 0);
  }

  private clear(): void {
    this.band = [0, 1, 2].map(() => this.rest.map(() => zero));
    this.right = this.rest.map(() => zero);
  }

  private term(first: number, factors: Complex[], wanted: Complex, weight: number): void {
    factors.forEach((factor, k) => { if (this.fixed[first + k]) wanted = wanted.sub(factor.mul(this.shift[first + k])); });
    factors.forEach((factor, k) => {
      const i = first + k;
      if (this.fixed[i]) return;
      this.right[i] = this.right[i].add(factor.conj().mul(wanted).scale(weight));
      for (let l = 0; l <= k; ++l) {
        if (this.fixed[first + l]) continue;
        this.band[k - l][i] = this.band[k - l][i].add(factor.conj().mul(factors[l]).scale(weight));
      }
    });
  }

  /* L D Lᴴ of a band. */
  private solve(): void {
    this.shift = this.shift.slice();
    const { right, fixed } = this, [d, one, two] = this.band, n = d.length;
    for (let i = 0; i < n; ++i) if (fixed[i]) { d[i] = new Complex(1, 0); right[i] = this.shift[i]; }
    for (let i = 0; i < n; ++i) {
      if (i >= 2) two[i] = two[i].scale(1 / d[i - 2].re);
      if (i >= 1) {
        const less = i >= 2 ? two[i].mul(d[i - 2]).mul(one[i - 1].conj()) : zero;
        one[i] = one[i].sub(less).scale(1 / d[i - 1].re);
      }
      let diagonal = d[i].re;
      if (i >= 1) diagonal -= one[i].abs ** 2 * d[i - 1].re;
      if (i >= 2) diagonal -= two[i].abs ** 2 * d[i - 2].re;
      d[i] = new Complex(diagonal, 0);
      if (i >= 1) right[i] = right[i].sub(one[i].mul(right[i - 1]));
      if (i >= 2) right[i] = right[i].sub(two[i].mul(right[i - 2]));
    }
    for (let i = n; i-- > 0;) {
      this.shift[i] = right[i].scale(1 / d[i].re);
      if (i + 1 < n) this.shift[i] = this.shift[i].sub(one[i + 1].conj().mul(this.shift[i + 1]));
      if (i + 2 < n) this.shift[i] = this.shift[i].sub(two[i + 2].conj().mul(this.shift[i + 2]));
    }
  }

  /* The frame of a knot between its neighbours, and the length of the two segments. */
  private frame(i: number): { factors: Complex[]; length: number } {
    const back = this.rest[i].sub(this.rest[i - 1]), ahead = this.rest[i + 1].sub(this.rest[i]), length = back.abs + ahead.abs;
    return { factors: [ahead.scale(1 / length), back.add(ahead).scale(-1 / length), back.scale(1 / length)], length };
  }

  keepAngles(): void {
    this.clear();
    for (let i = 1; i + 1 < this.rest.length; ++i) {
      const { factors, length } = this.frame(i);
      this.term(i - 1, factors, zero, (this.unit / length) ** 3);
    }
    this.solve();
  }

  /* What the lengths ask for is spread smoothly over about a fifth of the curve. */
  keepLengths(): void {
    const { rest, shift: before } = this, over = 0.2 * this.unit, ends = [new Complex(-1, 0), new Complex(1, 0)];
    this.clear();
    for (let i = 0; i + 1 < rest.length; ++i) {
      const edge = rest[i + 1].sub(rest[i]), now = edge.add(before[i + 1].sub(before[i]));
      this.term(i, ends, now.abs > 0 ? now.scale(edge.abs / now.abs).sub(edge) : zero, 1 / edge.abs);
    }
    for (let i = 1; i + 1 < rest.length; ++i) {
      const { factors, length } = this.frame(i);
      const bent = factors.reduce((sum, factor, k) => sum.add(factor.mul(before[i - 1 + k])), zero);
      this.term(i - 1, factors, bent, (32 * over * over) / length ** 3);
    }
    this.solve();
  }

}

/* ---- smoothing ----------------------------------------------------------------------------------------------------- */

/** Smooths knots by Taubin's filter (1995), each as much as `share` of it says, 0 not at all … 1 wholly. Ends stay. */
export function smoothed(knots: readonly Knot[], closed: boolean, amount: number, share: (knot: Knot) => number): Knot[] {
  let made = knots.map((knot) => ({ ...knot }));
  const n = made.length, shares = made.map(share), steps = Math.round(100 * Math.min(1, amount));
  if (n < 3) return made;
  for (let step = 0; step < 2 * steps; ++step) {
    const factor = step % 2 === 0 ? 0.5 : -0.53;
    made = made.map((knot, i) => {
      if (shares[i] <= 0 || (!closed && (i === 0 || i === n - 1))) return knot;
      const a = made[(i + n - 1) % n], b = made[(i + 1) % n], k = factor * shares[i];
      return { ...knot, x: knot.x + k * ((a.x + b.x) / 2 - knot.x), y: knot.y + k * ((a.y + b.y) / 2 - knot.y),
        corner: knot.corner && shares[i] < 0.5 };
    });
  }
  return made;
}
