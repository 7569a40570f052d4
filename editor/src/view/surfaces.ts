// The surfaces that colours flow from, as things to draw and to meet: packets `surface`, and the event that says which of
// them there are. What is being painted shows on them before the server has said so.

import * as THREE from 'three';
import type { Packet, Point, SurfacesEvent } from '../protocol';
import { meet, normalOf } from './pick';
import type { Shared } from './solids';
import lightSource from './light.glsl';
import surfaceFragment from './surface.frag.glsl';
import surfaceVertex from './surface.vert.glsl';

/** Where a ray meets a surface. */
export interface SurfaceHit {
  surface: Surface;
  triangle: number;
  point: THREE.Vector3;
  drawn: Point;                     // the same place where it was drawn: what brushes are about
  normal: THREE.Vector3;            // towards the front
  front: boolean;                   // is the front turned to the eye?
  distance: number;
}

/** Vertices in a colour, or a blur, that the server does not know of yet. */
export interface Coat {
  body: number;
  name: string;
  vertices: Set<number>;            // of what was drawn
  front: string | null;             // '#rrggbb'
  back: string | null;
  blur: number | null;
  until: number | null;             // the revision that has it; null: not asked for yet
}

export class Surface {
  readonly mesh: THREE.Mesh<THREE.BufferGeometry, THREE.RawShaderMaterial>;
  readonly body: number;
  readonly name: string;
  readonly key: string;
  readonly positions: Float32Array;
  readonly triangles: Uint32Array;
  readonly drawn: Float32Array;     // [vertices or fewer: they repeat]
  readonly front: Uint8Array;       // [vertices][4], as the server said
  readonly back: Uint8Array;
  readonly blur: Float32Array;
  readonly twoSided: boolean;
  readonly box = new THREE.Box3();
  /** Bounds the body: it is seen through, as skins are, unless it is chosen. */
  outer = false;

  constructor({ head, arrays }: Packet, shared: Shared) {
    this.body = head.body;
    this.name = head.name;
    this.key = head.key;
    this.positions = arrays.positions as Float32Array;
    this.triangles = arrays.triangles as Uint32Array;
    this.drawn = (arrays.drawn ?? arrays.positions) as Float32Array;
    this.front = arrays.front as Uint8Array;
    this.twoSided = arrays.back !== undefined;
    this.back = (arrays.back ?? arrays.front) as Uint8Array;
    this.blur = (arrays.blur ?? new Float32Array(this.positions.length / 3)) as Float32Array;
    this.box.setFromArray(this.positions);
    const geometry = new THREE.BufferGeometry(), bytes = (from: Uint8Array): THREE.BufferAttribute => {
      const made = new THREE.BufferAttribute(new Uint8Array(from), 4, true);
      made.setUsage(THREE.DynamicDrawUsage);
      return made;
    };
    geometry.setAttribute('position', new THREE.BufferAttribute(this.positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(arrays.normals as Float32Array, 3));
    geometry.setAttribute('front', bytes(this.front));
    geometry.setAttribute('back', bytes(this.back));
    geometry.setAttribute('value', new THREE.BufferAttribute(new Float32Array(2 * this.blur.length), 2));
    geometry.setIndex(new THREE.BufferAttribute(this.triangles, 1));
    geometry.boundingSphere = this.box.getBoundingSphere(new THREE.Sphere());
    this.mesh = new THREE.Mesh(geometry, new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: surfaceVertex, fragmentShader: surfaceFragment.replace('LIGHT', lightSource),
      side: THREE.DoubleSide,
      uniforms: { lightDirection: shared.lightDirection, upDirection: shared.upDirection, accent: shared.accent,
        clip: shared.clip, opacity: shared.opacity, chosen: { value: false }, showBlur: { value: false },
        hidden: { value: { none: 0, front: 1, back: 2 }[head.hide as string] ?? 0 }, mostBlur: { value: 0 },
        through: { value: false } },
    }));
    this.wipe();
  }

  private values(name: 'front' | 'back' | 'value'): THREE.BufferAttribute {
    return this.mesh.geometry.getAttribute(name) as THREE.BufferAttribute;
  }

  private touched = true;

  /** As the server said it, without coats and marks. */
  wipe(): void {
    if (!this.touched) return;
    this.touched = false;
    (this.values('front').array as Uint8Array).set(this.front);
    (this.values('back').array as Uint8Array).set(this.back);
    const value = this.values('value').array as Float32Array;
    let most = 0;
    this.blur.forEach((blur, v) => {
      value[2 * v] = blur;
      value[2 * v + 1] = 0;
      most = Math.max(most, blur);
    });
    this.mesh.material.uniforms.mostBlur.value = most;
    for (const name of ['front', 'back', 'value'] as const) this.values(name).needsUpdate = true;
  }

  /** Puts a coat on, on these of its vertices. */
  put(coat: Coat, vertices: Iterable<number> = coat.vertices): void {
    this.touched = true;
    const once = this.drawn.length / 3, count = this.positions.length / 3;
    const front = this.values('front'), back = this.values('back'), value = this.values('value');
    const { mostBlur } = this.mesh.material.uniforms, colourOf = (text: string): number[] =>
      [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
    const colours = [coat.front && colourOf(coat.front), coat.back && colourOf(coat.back)];
    for (const vertex of vertices)
      for (let v = vertex; v < count; v += once) {
        if (colours[0]) (front.array as Uint8Array).set(colours[0], 4 * v);
        if (colours[1]) (back.array as Uint8Array).set(colours[1], 4 * v);
        if (coat.blur !== null) value.array[2 * v] = coat.blur;
      }
    if (coat.blur !== null) mostBlur.value = Math.max(mostBlur.value, coat.blur);
    front.needsUpdate = back.needsUpdate = value.needsUpdate = true;
  }

  /** Marks the vertices for which `is` says so; null: none. */
  mark(is: ((x: number, y: number, z: number) => boolean) | null): void {
    const value = this.values('value'), { positions } = this;
    this.touched = true;
    for (let v = 0; 3 * v < positions.length; ++v) {
      value.array[2 * v + 1] = is?.(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]) ? 1 : 0;
    }
    value.needsUpdate = true;
  }

  /** The place of a triangle's point where the surface was drawn. */
  drawnAt(triangle: number, where: THREE.Vector3): Point {
    const corners = [0, 1, 2].map((k) => this.triangles[3 * triangle + k]), once = this.drawn.length / 3;
    const at = (from: Float32Array, v: number): THREE.Vector3 => new THREE.Vector3().fromArray(from, 3 * v);
    const [a, b, c] = corners.map((v) => at(this.positions, v)), weights = new THREE.Vector3();
    THREE.Triangle.getBarycoord(where, a, b, c, weights);
    const [p, q, r] = corners.map((v) => at(this.drawn, v % once));
    return p.multiplyScalar(weights.x).addScaledVector(q, weights.y).addScaledVector(r, weights.z).toArray() as Point;
  }

  /** How large a length on a triangle was where it was drawn. */
  drawnScale(triangle: number): number {
    const once = this.drawn.length / 3;
    const area = (from: Float32Array, wrap: boolean): number => {
      const [a, b, c] = [0, 1, 2].map((k) => {
        const v = this.triangles[3 * triangle + k];
        return new THREE.Vector3().fromArray(from, 3 * (wrap ? v % once : v));
      });
      return b.sub(a).cross(c.sub(a)).length();
    };
    const there = area(this.drawn, true), here = area(this.positions, false);
    return here > 0 && there > 0 ? Math.sqrt(there / here) : 1;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** All surfaces there are. */
export class SurfaceSet {
  readonly group = new THREE.Group();
  readonly box = new THREE.Box3();
  shown: Surface[] = [];            // those there are, in the document's order
  revision = 0;                     // that they are of
  private readonly known = new Map<string, Surface>();
  private coats: Coat[] = [];
  private listed: SurfacesEvent['bodies'] = [];
  private settled = true;           // is what is listed shown?

  constructor(private readonly shared: Shared) {}

  take(packet: Packet): void {
    const { key } = packet.head;
    if (!this.known.has(key)) this.known.set(key, new Surface(packet, this.shared));
    this.settle();
  }

  list(event: SurfacesEvent): void {
    this.listed = event.bodies;
    this.settled = false;
    this.revision = event.revision;
    this.coats = this.coats.filter(({ until }) => until === null || until > event.revision);
    if (!this.settle()) this.repaint();
  }

  /* Shows what is listed once all of it is here; what is not listed any more goes then. Packets come before they are
     listed, so they stay until another list has come. */
  private settle(): boolean {
    const wanted = this.listed.flatMap(({ surfaces }) => surfaces);
    if (this.settled || !wanted.every((key) => this.known.has(key))) return false;
    this.settled = true;
    this.shown = wanted.map((key) => this.known.get(key)!);
    this.group.clear();
    this.box.makeEmpty();
    for (const surface of this.shown) {
      this.group.add(surface.mesh);
      this.box.union(surface.box);
    }
    const keep = new Set(wanted);
    for (const [key, surface] of this.known) {
      if (keep.has(key)) continue;
      surface.dispose();
      this.known.delete(key);
    }
    this.repaint();
    this.onChange();
    return true;
  }
  /** Other surfaces are shown than before. */
  onChange: () => void = () => {};

  find(body: number, name: string | null): Surface | undefined {
    return this.shown.find((surface) => surface.body === body && surface.name === name);
  }

  /* ---- coats ---- */

  private repaint(): void {
    for (const surface of this.shown) {
      const coats = this.coats.filter(({ body, name }) => body === surface.body && name === surface.name);
      surface.wipe();
      for (const coat of coats) surface.put(coat);
    }
  }

  begin(coat: Coat): void { this.coats.push(coat); }

  extend(coat: Coat, vertices: number[]): void {
    for (const vertex of vertices) coat.vertices.add(vertex);
    this.find(coat.body, coat.name)?.put(coat, vertices);
  }

  /** The document has it from this revision on, or never. */
  end(coat: Coat, revision: number | null): void {
    coat.until = revision;
    if (revision !== null && revision > this.revision) return;
    this.coats = this.coats.filter((other) => other !== coat);
    this.repaint();
  }

  /* ---- meeting ---- */

  /** The first surface in sight that a ray meets; those that are seen through only where there is no other. only: no
      other than this. */
  hit(origin: THREE.Vector3, direction: THREE.Vector3, only?: Surface): SurfaceHit | null {
    const all = only ? [only] : this.shown.filter((surface) => surface.mesh.visible);
    const through = (surface: Surface): boolean => surface.mesh.material.uniforms.through.value;
    return this.nearest(origin, direction, all.filter((surface) => !through(surface)))
      ?? this.nearest(origin, direction, all.filter(through));
  }

  private nearest(origin: THREE.Vector3, direction: THREE.Vector3, among: Surface[]): SurfaceHit | null {
    let best: SurfaceHit | null = null;
    const { clip } = this.shared, plane = clip.value.lengthSq() > 0 ? clip.value : null;
    const passes = plane ? (x: number, y: number, z: number) => x * plane.x + y * plane.y + z * plane.z <= plane.w : undefined;
    for (const surface of among) {
      const { positions, triangles } = surface;
      const found = meet(origin, direction, positions, triangles, 0, triangles.length / 3, passes);
      if (!found || (best && best.distance <= found.distance)) continue;
      const point = origin.clone().addScaledVector(direction, found.distance);
      const normal = normalOf(positions, triangles, found.triangle);
      best = { surface, triangle: found.triangle, point, drawn: surface.drawnAt(found.triangle, point), normal,
        front: normal.dot(direction) < 0, distance: found.distance };
    }
    return best;
  }

  /* ---- drawing ---- */

  /** Sets what is in sight: `visible` by name for the body that tools work on; the chosen one stands out. */
  look(body: number, visible: { [name: string]: boolean }, chosen: string | null, blur: boolean, outer: (surface: Surface) => boolean): void {
    for (const surface of this.shown) {
      const { uniforms } = surface.mesh.material, own = surface.body === body;
      surface.mesh.visible = !own || visible[surface.name] !== false;
      uniforms.chosen.value = own && surface.name === chosen;
      uniforms.showBlur.value = blur;
      surface.outer = outer(surface);
      uniforms.through.value = surface.outer && !uniforms.chosen.value;
    }
  }

  /** Draws what is opaque, or what is seen through, over what is there. */
  draw(renderer: THREE.WebGLRenderer, camera: THREE.Camera, through: boolean): void {
    const kept = this.shown.map(({ mesh }) => mesh.visible);
    for (const { mesh } of this.shown) {
      const own = mesh.material.uniforms.through.value as boolean;
      mesh.visible &&= own === through;
      mesh.material.transparent = own;
      mesh.material.depthWrite = !own;
    }
    renderer.render(this.group, camera);
    this.shown.forEach(({ mesh }, i) => { mesh.visible = kept[i]; });
  }
}
