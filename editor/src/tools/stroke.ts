// A stroke under way: the points of a drag, thinned as they come, shown on the overlay at once.

import type { Vector3 } from 'three';
import type { Point } from '../protocol';

export interface FlatPoint { x: number; y: number }

/** Keeps the corners of a drag: points nearer than `least` pixels to the last are left out. */
export class FlatStroke {
  readonly points: FlatPoint[] = [];
  constructor(private readonly least = 3) {}

  add(x: number, y: number): boolean {
    const last = this.points[this.points.length - 1];
    if (last && Math.hypot(x - last.x, y - last.y) < this.least) return false;
    this.points.push({ x, y });
    return true;
  }

  get length(): number {
    let sum = 0;
    for (let i = 1; i < this.points.length; ++i) sum += Math.hypot(this.points[i].x - this.points[i - 1].x, this.points[i].y - this.points[i - 1].y);
    return sum;
  }
}

/** A polyline with the corners left out that lie within `tolerance` of the line without them (Douglas and Peucker 1973). */
export function simplify<T>(points: T[], tolerance: number, distance: (p: T, a: T, b: T) => number): T[] {
  const keep = new Uint8Array(points.length), stack: [number, number][] = [[0, points.length - 1]];
  if (points.length < 3) return points.slice();
  keep[0] = keep[points.length - 1] = 1;
  while (stack.length > 0) {
    const [first, last] = stack.pop()!;
    let worst = 0, at = -1;
    for (let i = first + 1; i < last; ++i) {
      const away = distance(points[i], points[first], points[last]);
      if (away > worst) worst = away, at = i;
    }
    if (worst > tolerance) {
      keep[at] = 1;
      stack.push([first, at], [at, last]);
    }
  }
  return points.filter((_, i) => keep[i]);
}

export function flatDistance(p: FlatPoint, a: FlatPoint, b: FlatPoint): number {
  const dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
  const along = square > 0 ? Math.min(1, Math.max(0, ((p.x - a.x) * dx + (p.y - a.y) * dy) / square)) : 0;
  return Math.hypot(p.x - a.x - along * dx, p.y - a.y - along * dy);
}

export function spaceDistance(p: Vector3, a: Vector3, b: Vector3): number {
  const line = b.clone().sub(a), square = line.lengthSq();
  const along = square > 0 ? Math.min(1, Math.max(0, p.clone().sub(a).dot(line) / square)) : 0;
  return p.distanceTo(a.clone().addScaledVector(line, along));
}

/** As documents write points: seven digits are finer than any model. */
export const toPoint = (v: Vector3): Point => v.toArray().map((x) => Number(x.toPrecision(8))) as Point;
