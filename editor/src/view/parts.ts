// The parts of the view as things to draw: the packet `view` (or, before anything is built, the bare meshes) unfolded to
// one vertex a corner, and what is needed to meet them with a ray.

import * as THREE from 'three';
import type { Packet, PartHead, Point } from '../protocol';
import { LAYER_WIDTH, PAINT_WIDTH, BodySolid, partMaterial, tableTexture, type Shared } from './solids';

const NO_FACE = 0x7fffffff, SECTION = 0x80000000;

/** The cleaned mesh of a body with what is painted on it. */
export class BodyMesh {
  positions: Float32Array = new Float32Array();
  triangles: Uint32Array = new Uint32Array();
  painted: Float32Array = new Float32Array();
  paint: THREE.DataTexture;
  box = new THREE.Box3();
  head: Packet['head'];

  constructor(packet: Packet) {
    this.head = packet.head;
    this.paint = this.update(packet);
  }

  update(packet: Packet): THREE.DataTexture {
    const { arrays, head } = packet;
    this.head = head;
    if (arrays.positions) {
      this.positions = arrays.positions as Float32Array;
      this.triangles = arrays.triangles as Uint32Array;
      this.box.setFromArray(this.positions);
    }
    this.painted = new Float32Array(arrays.painted as Float32Array);
    return this.repaint();
  }

  /** Takes the painted depths over into the texture, after they were changed in place. */
  repaint(): THREE.DataTexture {
    const shown = this.painted.map((depth) => (Number.isNaN(depth) ? -1 : depth));
    this.paint?.dispose();
    this.paint = tableTexture(shown, PAINT_WIDTH, THREE.RedFormat, THREE.FloatType, 'R32F');
    return this.paint;
  }

  /** Shows a few faces in another depth at once, before the server has said so. */
  preview(faces: Iterable<number>, depth: number): void {
    const data = this.paint.image.data as unknown as Float32Array;
    for (const face of faces) { data[face] = depth; this.painted[face] = depth < 0 ? NaN : depth; }
    this.paint.needsUpdate = true;
  }
}

/** One part: its triangles in the view's arrays, its mesh in the scene, where it is moved to. */
export interface ViewPart extends PartHead {
  mesh: THREE.Mesh<THREE.BufferGeometry, THREE.RawShaderMaterial>;
  middle: THREE.Vector3;
  box: THREE.Box3;
}

export class View {
  readonly group = new THREE.Group();
  readonly parts: ViewPart[] = [];
  readonly box = new THREE.Box3();
  /** The box of the parts as one body, without their offsets. */
  readonly together = new THREE.Box3();
  readonly positions: Float32Array;
  readonly material: Float32Array;
  readonly corners: Uint32Array;
  readonly kinds: Uint8Array;
  readonly faces: Uint32Array;
  readonly head: Packet['head'];
  readonly bytes: number;
  /** Bodies whose skin has colours of its own. */
  readonly skinned = new Set<number>();
  private readonly normals: Int16Array | undefined;
  private readonly owned: THREE.Texture[] = [];

  constructor(packet: Packet, readonly bare: boolean, shared: Shared, solids: Map<number, BodySolid>, meshes: Map<number, BodyMesh>) {
    const { arrays, head } = packet;
    this.head = head;
    this.bytes = packet.bytes;
    this.positions = arrays.positions as Float32Array;
    this.material = (arrays.material ?? arrays.positions) as Float32Array;
    this.corners = arrays.corners as Uint32Array;
    this.kinds = arrays.kinds as Uint8Array;
    this.faces = arrays.faces as Uint32Array;
    this.normals = arrays.normals as Int16Array | undefined;
    const layers = arrays.layers as Uint32Array | undefined;
    const texture = tableTexture(layers && layers.length ? layers : new Uint32Array(4), LAYER_WIDTH, THREE.RGBAIntegerFormat,
                                 THREE.UnsignedIntType, 'RGBA32UI');
    this.owned.push(texture);
    for (const part of head.parts as PartHead[]) {
      const own = this.partUniforms(part, texture, meshes);
      const defines: { [name: string]: number } = {};
      if (arrays.material) defines.MOVED = 1;
      if (!arrays.normals) defines.FACETED = 1;
      const material = partMaterial(shared, solids.get(part.body) ?? null, own, defines);
      const mesh = new THREE.Mesh(this.unfold(part, packet), material);
      if (solids.get(part.body)?.defines.GRID) {
        mesh.geometry.setAttribute('skin', new THREE.BufferAttribute(new Uint8Array(12 * part.triangles[1]), 4, true));
      }
      mesh.visible = !part.hidden;
      mesh.position.set(...part.offset);
      const box = mesh.geometry.boundingBox!;
      this.parts.push({ ...part, mesh, box, middle: box.getCenter(new THREE.Vector3()) });
      this.box.union(box.clone().translate(mesh.position));
      this.together.union(box);
      this.group.add(mesh);
    }
  }

  private partUniforms(part: PartHead, layers: THREE.Texture, meshes: Map<number, BodyMesh>): { [name: string]: THREE.IUniform } {
    const paint = meshes.get(part.body)?.paint ?? null;
    return {
      layers: { value: layers }, rtUnit: { value: this.head.rt_unit ?? 1 }, sUnit: { value: this.head.s_unit ?? 1 },
      hasDepth: { value: this.head.depth ?? false }, hasPaint: { value: paint !== null }, painted: { value: paint },
      picked: { value: false }, stale: { value: false }, body: { value: part.body },
    };
  }

  /* One vertex a corner; positions, depths and normals of corners, and of each triangle its list of layers and its face. */
  private unfold(part: PartHead, packet: Packet): THREE.BufferGeometry {
    const [first, count] = part.triangles, corners = 3 * count, { arrays } = packet;
    const depths = arrays.depth as Uint16Array | undefined, normals = arrays.normals as Int16Array | undefined;
    const starts = arrays.layer_start as Uint32Array | undefined;
    const positions = new Float32Array(3 * corners), depth = new Uint16Array(corners), info = new Uint32Array(3 * corners);
    const moved = arrays.material ? new Float32Array(3 * corners) : null;
    const box = new THREE.Box3();
    for (let t = 0, c = 0; t < count; ++t) {
      const triangle = first + t, start = starts ? starts[triangle] : 0, length = starts ? starts[triangle + 1] - start : 0;
      const section = this.kinds[triangle] === 1;
      const face = section ? NO_FACE : this.faces[triangle] & NO_FACE;
      for (let k = 0; k < 3; ++k, ++c) {
        const v = this.corners[3 * triangle + k];
        positions[3 * c] = this.positions[3 * v];
        positions[3 * c + 1] = this.positions[3 * v + 1];
        positions[3 * c + 2] = this.positions[3 * v + 2];
        if (moved) for (let axis = 0; axis < 3; ++axis) moved[3 * c + axis] = this.material[3 * v + axis];
        if (depths) depth[c] = depths[v];
        info[3 * c] = start;
        info[3 * c + 1] = length;
        info[3 * c + 2] = section ? (face | SECTION) >>> 0 : face;
      }
    }
    box.setFromArray(positions);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    if (moved) geometry.setAttribute('material', new THREE.BufferAttribute(moved, 3));
    geometry.setAttribute('depth', new THREE.BufferAttribute(depth, 1, true));
    const oct = normals ? normals.slice(6 * first, 6 * (first + count)) : new Int16Array(2 * corners);
    geometry.setAttribute('normal', new THREE.BufferAttribute(oct, 2, true));
    geometry.setAttribute('info', new THREE.BufferAttribute(info, 3));
    geometry.boundingBox = box;
    geometry.boundingSphere = box.getBoundingSphere(new THREE.Sphere());
    return geometry;
  }

  /** The vertices of a body's skin, with places and normals, for asking their colours. */
  skinOf(body: number): { vertices: Uint32Array; points: Float32Array; normals: Float32Array } | null {
    const { normals, material } = this, corner = new Map<number, number>();
    if (!normals) return null;
    for (const { body: own, triangles: [first, count] } of this.parts) {
      if (own !== body) continue;
      for (let c = 3 * first; c < 3 * (first + count); ++c) {
        if (this.kinds[Math.floor(c / 3)] === 0 && !corner.has(this.corners[c])) corner.set(this.corners[c], c);
      }
    }
    const vertices = Uint32Array.from(corner.keys()), points = new Float32Array(3 * vertices.length);
    const found = new Float32Array(points.length);
    let i = 0;
    for (const [v, c] of corner) {
      points.set(material.subarray(3 * v, 3 * v + 3), 3 * i);
      found.set(unfoldNormal(normals[2 * c] / 32767, normals[2 * c + 1] / 32767), 3 * i++);
    }
    return { vertices, points, normals: found };
  }

  /** Shows these colours, [vertices][4], on the skin where a solid is drawn from voxels: those lie within it. */
  colourSkin(body: number, vertices: Uint32Array, colours: Uint8Array): void {
    const place = new Map<number, number>();
    this.skinned.add(body);
    vertices.forEach((v, i) => place.set(v, i));
    for (const { body: own, triangles: [first, count], mesh } of this.parts) {
      const skin = mesh.geometry.getAttribute('skin') as THREE.BufferAttribute | undefined;
      if (own !== body || !skin) continue;
      for (let c = 0; c < 3 * count; ++c) {
        const i = place.get(this.corners[3 * first + c]);
        if (i === undefined) continue;
        for (let k = 0; k < 3; ++k) skin.array[4 * c + k] = colours[4 * i + k];
        skin.array[4 * c + 3] = 255;
      }
      skin.needsUpdate = true;
    }
  }

  /** Moves the parts to where they are seen: at their offsets times `together`, and `apart` away from the middle of all. */
  arrange(together: number, apart: number): void {
    const middle = this.box.getCenter(new THREE.Vector3()), away = new THREE.Vector3();
    for (const part of this.parts) {
      part.mesh.position.set(...part.offset).multiplyScalar(together);
      part.mesh.position.addScaledVector(away.copy(part.middle).sub(middle), apart);
      part.mesh.updateMatrixWorld();
    }
  }

  /** The painted depths of a body were put into another texture. */
  repaint(body: number, paint: THREE.Texture): void {
    for (const part of this.parts) {
      if (part.body !== body) continue;
      part.mesh.material.uniforms.painted.value = paint;
      part.mesh.material.uniforms.hasPaint.value = true;
    }
  }

  dispose(): void {
    for (const part of this.parts) {
      part.mesh.geometry.dispose();
      part.mesh.material.dispose();
    }
    for (const texture of this.owned) texture.dispose();
    this.group.clear();
  }
}

/* As part.vert.glsl does. */
function unfoldNormal(x: number, y: number): [number, number, number] {
  const z = 1 - Math.abs(x) - Math.abs(y);
  const [u, v] = z < 0 ? [(1 - Math.abs(y)) * (x >= 0 ? 1 : -1), (1 - Math.abs(x)) * (y >= 0 ? 1 : -1)] : [x, y];
  const length = Math.hypot(u, v, z) || 1;
  return [u / length, v / length, z / length];
}

/** The bare meshes as a view: what is seen before anything was built. */
export function bareView(meshes: Map<number, BodyMesh>): Packet {
  const bodies = [...meshes.entries()].sort(([a], [b]) => a - b), parts: PartHead[] = [];
  let vertices = 0, triangles = 0;
  for (const [body, mesh] of bodies) {
    const count = { v: mesh.positions.length / 3, t: mesh.triangles.length / 3 };
    parts.push({ body, offset: [0, 0, 0] as Point, hidden: false, inside: [0, 0, 0] as Point, triangles: [triangles, count.t], vertices: [vertices, count.v] });
    vertices += count.v;
    triangles += count.t;
  }
  const positions = new Float32Array(3 * vertices), corners = new Uint32Array(3 * triangles), faces = new Uint32Array(triangles);
  bodies.forEach(([, mesh], i) => {
    positions.set(mesh.positions, 3 * parts[i].vertices[0]);
    for (let c = 0; c < mesh.triangles.length; ++c) corners[3 * parts[i].triangles[0] + c] = mesh.triangles[c] + parts[i].vertices[0];
    for (let t = 0; t < parts[i].triangles[1]; ++t) faces[parts[i].triangles[0] + t] = t;
  });
  return { kind: 'view', head: { parts, depth: false }, arrays: { positions, corners, faces, kinds: new Uint8Array(triangles) }, bytes: 0 };
}
