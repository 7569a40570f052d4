// What the multi-face fill reaches from a face: for showing it at once, and for wiping it. The server does the painting
// itself, by the same rule: over edges that bend by no more than the crease angle, faces of the same depth.

export class Reach {
  private readonly across: Int32Array;  // [triangles][3]: the triangle beyond each edge, -1 for none
  private readonly normals: Float32Array;

  /** Finds the neighbours of all triangles; O(triangles). positions [vertices][3], triangles [triangles][3]. */
  constructor(positions: Float32Array, private readonly triangles: Uint32Array) {
    const count = triangles.length / 3, edges = new Map<number, number>(), vertices = positions.length / 3;
    this.across = new Int32Array(triangles.length).fill(-1);
    this.normals = new Float32Array(triangles.length);
    for (let t = 0; t < count; ++t) {
      this.setNormal(positions, t);
      for (let k = 0; k < 3; ++k) {
        const a = triangles[3 * t + k], b = triangles[3 * t + ((k + 1) % 3)];
        const key = Math.min(a, b) * vertices + Math.max(a, b), other = edges.get(key);
        if (other === undefined) edges.set(key, 3 * t + k);
        else {
          this.across[3 * t + k] = Math.floor(other / 3);
          this.across[other] = t;
        }
      }
    }
  }

  private setNormal(positions: Float32Array, t: number): void {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * this.triangles[3 * t + k]);
    const u = [0, 1, 2].map((i) => positions[b + i] - positions[a + i]),
      v = [0, 1, 2].map((i) => positions[c + i] - positions[a + i]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...n) || 1;
    this.normals.set(n.map((x) => x / length), 3 * t);
  }

  /** The faces reached from one, itself first. painted [triangles], NaN without a depth; crease in degrees. */
  from(face: number, painted: Float32Array, crease: number): number[] {
    const found = [face], seen = new Set(found), least = Math.cos((crease * Math.PI) / 180) - 1e-9;
    const depth = painted[face];
    const same = (other: number): boolean => painted[other] === depth
      || (Number.isNaN(depth) && Number.isNaN(painted[other]));
    for (let at = 0; at < found.length; ++at) {
      for (let k = 0; k < 3; ++k) {
        const other = this.across[3 * found[at] + k];
        if (other < 0 || seen.has(other) || !same(other) || !(this.bend(found[at], other) >= least)) continue;
        seen.add(other);
        found.push(other);
      }
    }
    return found;
  }

  /* Cosine of the angle between two faces. */
  private bend(a: number, b: number): number {
    const { normals } = this;
    return normals[3 * a] * normals[3 * b] + normals[3 * a + 1] * normals[3 * b + 1] + normals[3 * a + 2] * normals[3 * b + 2];
  }
}
