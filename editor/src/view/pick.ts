// Meeting triangles with a ray (Möller and Trumbore 1997). All of them are tried: a hundred thousand take a millisecond
// or two, less than keeping a tree after every cut.

import * as THREE from 'three';

export interface Meeting { triangle: number; distance: number }

/** The first triangle of [first, first + count) that the ray meets from outside or inside; null when there is none. */
export function meet(origin: THREE.Vector3, direction: THREE.Vector3, positions: Float32Array, corners: Uint32Array, first: number,
                     count: number, passes?: (x: number, y: number, z: number) => boolean): Meeting | null {
  const { x: ox, y: oy, z: oz } = origin, { x: dx, y: dy, z: dz } = direction;
  let best = Infinity, found = -1;
  for (let t = first; t < first + count; ++t) {
    const a = 3 * corners[3 * t], b = 3 * corners[3 * t + 1], c = 3 * corners[3 * t + 2];
    const ax = positions[a], ay = positions[a + 1], az = positions[a + 2];
    const ux = positions[b] - ax, uy = positions[b + 1] - ay, uz = positions[b + 2] - az;
    const vx = positions[c] - ax, vy = positions[c + 1] - ay, vz = positions[c + 2] - az;
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
    const determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const inverse = 1 / determinant, sx = ox - ax, sy = oy - ay, sz = oz - az;
    const u = (sx * px + sy * py + sz * pz) * inverse;
    if (!(u >= 0 && u <= 1)) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const v = (dx * qx + dy * qy + dz * qz) * inverse;
    if (!(v >= 0 && u + v <= 1)) continue;
    const distance = (vx * qx + vy * qy + vz * qz) * inverse;
    if (!(distance > 0 && distance < best)) continue;
    if (passes && !passes(ox + distance * dx, oy + distance * dy, oz + distance * dz)) continue;
    best = distance;
    found = t;
  }
  return found < 0 ? null : { triangle: found, distance: best };
}

/** Unit normal of a triangle. */
export function normalOf(positions: Float32Array, corners: Uint32Array, triangle: number): THREE.Vector3 {
  const [a, b, c] = [0, 1, 2].map((k) => new THREE.Vector3().fromArray(positions, 3 * corners[3 * triangle + k]));
  return b.sub(a).cross(c.sub(a)).normalize();
}
