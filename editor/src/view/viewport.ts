// The view: what the server sent as a picture one can turn, pick and draw on. Drawn when something changed, not all the
// time.

import * as THREE from 'three';
import type { Json, Packet, SurfacesEvent } from '../protocol';
import type { Hit } from '../tools/tool';
import { PointPass, type ColourSheet, type SeenPoints } from './asked';
import { Hands, Turntable } from './camera';
import { Overlay } from './overlay';
import { bareView, BodyMesh, View, type ViewPart } from './parts';
import { meet, normalOf } from './pick';
import { BodySolid, setAnisotropy, sharedUniforms } from './solids';
import { layerMesh, lineObject } from './looks';
import { SurfaceSet, type Surface, type SurfaceHit } from './surfaces';

/** An exemplar shown where it would be set: its texture, and where its cube stands. */
export interface Ghost {
  texture: THREE.Data3DTexture;
  point: THREE.Vector3;
  up: THREE.Vector3;            // along s
  along: THREE.Vector3;         // along t
  size: number;
  radius: number;
  dropOff: number;
}

export class Viewport {
  readonly element = document.createElement('div');
  readonly canvas: HTMLCanvasElement;
  readonly table = new Turntable();
  readonly hands: Hands;
  readonly overlay: Overlay;
  readonly solids = new Map<number, BodySolid>();
  readonly meshes = new Map<number, BodyMesh>();
  view: View | null = null;
  /** Called after each picture, with the milliseconds it took to draw; benchmarks and the status bar listen. */
  onDraw: ((milliseconds: number) => void)[] = [];
  /** Called when a view packet has been taken over. */
  onView: (() => void)[] = [];

  private readonly renderer: THREE.WebGLRenderer;
  /** Drawn in software: coarsely while something moves, finely when it has come to rest. */
  readonly slow: boolean;
  private coarse = false;
  private rest = 0;
  private readonly scene = new THREE.Scene();
  private readonly shared = sharedUniforms();
  private readonly floor: THREE.Mesh;
  private layer: { mesh: THREE.Mesh; body: number } | null = null;
  private lines: THREE.Mesh[] = [];
  private readonly ribbons = { resolution: { value: new THREE.Vector2(1, 1) }, pale: { value: 0 } };
  readonly surfaces: SurfaceSet;
  private within = false;           // the surfaces are shown, and the model about them is seen through
  private section: View | null = null;
  private readonly pass: PointPass;
  private sheet: { of: string; whole: boolean; sheet: ColourSheet } | null = null;
  private ghostOn = false;
  private wanted = false;
  private together = 1;
  private apart = 0;
  private framed = false;
  /** The camera was moved by hand: it stays where it is. */
  touched = false;
  private lightAzimuth = -50;
  private lightElevation = 48;

  constructor() {
    this.element.className = 'viewport';
    this.slow = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.slow, alpha: true, powerPreference: 'high-performance' });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the parts' shader encodes by itself
    this.renderer.setClearColor(0x000000, 0);
    this.canvas = this.renderer.domElement;
    this.pass = new PointPass(this.renderer, this.shared);
    this.surfaces = new SurfaceSet(this.shared);
    setAnisotropy(this.slow ? 1 : Math.min(8, this.renderer.capabilities.getMaxAnisotropy()));
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'The model. Drag to turn it, with the right button in any tool.');
    this.overlay = new Overlay(this.table.camera);
    this.element.append(this.canvas, this.overlay.canvas);
    this.floor = shadowOnTheFloor();
    this.scene.add(this.floor);
    this.hands = new Hands(this.table, this.element, (x, y) => this.hit(x, y)?.world);
    this.table.onChange = () => {
      this.moved = performance.now();
      this.invalidate();
    };
    this.element.addEventListener('pointerdown', () => { this.touched = this.view !== null; }, { capture: true });
    this.element.addEventListener('wheel', () => { this.touched = this.view !== null; }, { capture: true, passive: true });
    new ResizeObserver(() => this.resize()).observe(this.element);
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.invalidate());
  }

  /* ---- what the server sent ---- */

  /** Takes a packet over; false when it is none of the view's. */
  take(packet: Packet): boolean {
    if (packet.kind === 'mesh') this.takeMesh(packet);
    else if (packet.kind === 'solid') this.takeSolid(packet);
    else if (packet.kind === 'view') this.takeView(packet);
    else if (packet.kind === 'surface') this.surfaces.take(packet);
    else return false;
    this.invalidate();
    return true;
  }

  /** Which surfaces there are; without a model they are what there is to see. */
  listSurfaces(event: SurfacesEvent): void {
    this.surfaces.list(event);
    if (!this.view && !this.surfaces.box.isEmpty()) {
      this.table.see(this.surfaces.box);
      if (!this.touched) this.table.fromDocument(this.statedCamera);
    }
    this.invalidate();
  }

  private takeMesh(packet: Packet): void {
    const { body } = packet.head, known = this.meshes.get(body);
    if (known) this.view?.repaint(body, known.update(packet));
    else {
      const mesh = new BodyMesh(packet);
      this.meshes.set(body, mesh);
      this.view?.repaint(body, mesh.paint);
    }
    // Until something is built the bare mesh is what there is to see; a new shape takes its place too.
    if (!this.view || this.view.bare) this.replaceView(bareView(this.meshes), true);
  }

  private takeSolid(packet: Packet): void {
    const { body } = packet.head;
    const old = this.solids.get(body);
    this.solids.set(body, new BodySolid(packet));
    // The view that goes with it follows; until then the old one keeps its textures.
    if (old) this.retired.push(old);
  }
  private readonly retired: BodySolid[] = [];

  private takeView(packet: Packet): void {
    this.replaceView(packet, false);
    for (const old of this.retired.splice(0)) old.dispose();
  }

  private replaceView(packet: Packet, bare: boolean): void {
    const view = new View(packet, bare, this.shared, this.solids, this.meshes);
    if (this.view) {
      this.scene.remove(this.view.group);
      this.view.dispose();
    }
    this.view = view;
    this.scene.add(view.group);
    this.dropSection();
    view.arrange(this.together, this.apart);
    this.table.see(view.box);
    this.placeFloor();
    if (!this.framed && !this.touched && !view.box.isEmpty()) { // until there is a cut model that is the bare mesh
      this.framed = !bare;
      this.table.fromDocument(this.statedCamera);
    }
    this.stale(this.staleBodies);
    for (const call of this.onView) call();
  }

  private statedCamera: Json | undefined;
  /** Takes the document's camera for the first picture, also when the packets came first; not from under a hand. */
  stateCamera(camera: Json | undefined): void {
    this.statedCamera = camera;
    if (this.view && !this.touched) this.table.fromDocument(camera);
  }
  private staleBodies: Set<number> = new Set();

  /** Bodies whose solid is not that of the present document: they are drawn paler. */
  stale(bodies: Set<number>): void {
    this.staleBodies = bodies;
    for (const part of this.view?.parts ?? []) {
      const { stale } = part.mesh.material.uniforms;
      if (stale.value === bodies.has(part.body)) continue;
      stale.value = !stale.value;
      this.invalidate(); // only then: a picture more would hold up the next packet
    }
  }

  /** The section that a plane under the pointer would lay open; null: none. The parts are clipped at the plane. */
  preview(packet: Packet | null, plane: THREE.Plane | null): void {
    this.dropSection();
    if (plane) this.shared.clip.value.set(plane.normal.x, plane.normal.y, plane.normal.z, -plane.constant);
    else this.shared.clip.value.set(0, 0, 0, 0);
    if (packet && this.view) {
      const still = { ...this.shared, clip: { value: new THREE.Vector4(0, 0, 0, 0) } };
      this.section = new View(packet, false, still, this.solids, this.meshes);
      this.section.arrange(this.together, 0);
      this.scene.add(this.section.group);
    }
    this.invalidate();
  }

  private dropSection(): void {
    if (!this.section) return;
    this.scene.remove(this.section.group);
    this.section.dispose();
    this.section = null;
  }

  /* ---- how it is looked at ---- */

  look(how: { mode?: number; isolines?: boolean; edges?: boolean; unlit?: boolean; accent?: THREE.Color }): void {
    if (how.mode !== undefined) this.shared.mode.value = how.mode;
    if (how.isolines !== undefined) this.shared.showIsolines.value = how.isolines;
    if (how.edges !== undefined) this.shared.showEdges.value = how.edges;
    if (how.unlit !== undefined) this.shared.unlit.value = how.unlit;
    if (how.accent) this.shared.accent.value.set(how.accent.r, how.accent.g, how.accent.b);
    this.invalidate();
  }

  /** Shows the surfaces within the model, its skin seen through to this degree; null: not. */
  lookWithin(skin: number | null): void {
    this.within = skin !== null;
    this.shared.show.value = this.within ? 1 : 0;
    this.shared.opacity.value = skin ?? 1;
    this.invalidate();
  }

  light(azimuth: number, elevation: number): void {
    if (azimuth === this.lightAzimuth && elevation === this.lightElevation) return;
    this.lightAzimuth = azimuth;
    this.lightElevation = elevation;
    this.invalidate();
  }

  /** together: 1 at the document's offsets, 0 as one body; apart: pulled away from the middle, in radii of the model. */
  arrange(together: number, apart: number): void {
    if (!this.view) return;
    this.together = together;
    this.apart = apart;
    this.view.arrange(together, apart);
    this.section?.arrange(together, 0);
    this.invalidate();
  }

  pick(part: number | null): void {
    this.view?.parts.forEach((one, i) => {
      const { picked } = one.mesh.material.uniforms;
      if (picked.value === (i === part)) return;
      picked.value = i === part;
      this.invalidate();
    });
  }

  /** Where the brush is: a ring of this radius (world) on the surface; null: nowhere. */
  brush(at: THREE.Vector3 | null, radius = 0, normal?: THREE.Vector3): void {
    if (!at) return this.overlay.show('brush', null);
    const n = normal ?? this.table.camera.position.clone().sub(at).normalize();
    const u = new THREE.Vector3(Math.abs(n.x) < 0.8 ? 1 : 0, Math.abs(n.x) < 0.8 ? 0 : 1, 0).cross(n).normalize(), v = n.clone().cross(u);
    const ring = Array.from({ length: 40 }, (_, i) => {
      const angle = (i / 40) * 2 * Math.PI;
      return at.clone().addScaledVector(u, radius * Math.cos(angle)).addScaledVector(v, radius * Math.sin(angle));
    });
    this.overlay.show('brush', [{ points: ring, colour: '#ffffff', width: 1.5, closed: true }]);
  }

  /** Shows painted depths on faces of a body at once. depth below 0: without paint. */
  paint(body: number, faces: Iterable<number>, depth: number): void {
    this.meshes.get(body)?.preview(faces, depth);
    this.invalidate();
  }

  /** Shows a layer of depth (packet `layer`), the rest of the model seen through; null: no layer. */
  showLayer(packet: Packet | null, body = 0): void {
    if (this.layer) {
      this.scene.remove(this.layer.mesh);
      this.layer.mesh.geometry.dispose();
      (this.layer.mesh.material as THREE.Material).dispose();
      this.layer = null;
    }
    if (packet) {
      this.layer = { mesh: layerMesh(packet, this.shared), body };
      this.scene.add(this.layer.mesh);
    }
    for (const part of this.view?.parts ?? []) part.mesh.visible = !part.hidden && !packet;
    this.invalidate();
  }

  /** Shows streamlines (packets `lines`); an empty list: none. */
  showLines(packets: Packet[]): void {
    for (const old of this.lines) {
      this.scene.remove(old);
      old.geometry.dispose();
      (old.material as THREE.Material).dispose();
    }
    this.lines = packets.map((packet) => lineObject(packet, this.view?.parts ?? [], this.ribbons));
    if (this.lines.length > 0) this.scene.add(...this.lines);
    this.invalidate();
  }

  /** Shows an exemplar where it would be set, over whatever is there; null: none. */
  ghost(ghost: Ghost | null): void {
    for (const part of [...(this.view?.parts ?? []), ...(this.section?.parts ?? [])]) setGhost(part, ghost);
    this.ghostOn = ghost !== null;
    this.invalidate();
  }
  get ghosting(): boolean { return this.ghostOn; }

  /* ---- colours point by point ---- */

  /** What the picture shows, in a word: camera, parts, and solids that are drawn from voxels; null while there are none
      such to be seen, or it is drawn coarsely. */
  seen(): string | null {
    const { view, canvas } = this, { camera } = this.table, clip = this.shared.clip.value;
    if (!view || view.bare || this.coarse || this.layer || this.shared.mode.value !== 0) return null;
    const bodies = this.voxelBodies();
    if (bodies.length === 0) return null;
    const parts = view.parts.map(({ mesh }) => (mesh.visible ? mesh.position.toArray() : 0));
    return JSON.stringify([view.head.serial, bodies.map((body) => this.solids.get(body)!.serial), canvas.width,
      canvas.height, camera.matrixWorld.elements, camera.projectionMatrix.elements, parts, clip.toArray(),
      this.section?.head.serial, this.within]);
  }

  /** Bodies in the view whose solids are drawn from voxels. */
  voxelBodies(): number[] {
    const bodies = new Set((this.view?.parts ?? []).map((part) => part.body));
    return [...bodies].filter((body) => this.solids.get(body)?.defines.GRID);
  }

  /** The points of such a body that are seen, moved from the middles of the pixels by parts of one; `painted`: but for
      its skin, where the colours of that are known. */
  seePoints(body: number, turned: boolean, painted: boolean, [dx, dy]: readonly [number, number]): SeenPoints {
    const groups = [this.view!.group, ...(this.section ? [this.section.group] : [])], { camera } = this.table;
    const { width, height } = this.canvas;
    camera.setViewOffset(width, height, dx, dy, width, height);
    const found = this.pass.see(body, groups, camera, turned, painted && this.view!.skinned.has(body));
    camera.clearViewOffset();
    return found;
  }

  /** Shows the colours of a sheet as long as the picture shows the same; `whole`: there will be no more of them. */
  showColours(sheet: ColourSheet, of: string, whole: boolean): void {
    if (this.sheet && this.sheet.sheet !== sheet) this.sheet.sheet.texture.dispose();
    this.sheet = { of, whole, sheet };
    this.shared.colours.value = sheet.texture;
    this.invalidate();
  }

  /** Has everything seen its own colour? */
  get fine(): boolean { return this.seen() === null || (this.sheet?.whole === true && this.sheet.of === this.seen()); }

  get lightDirection(): number[] { return this.shared.lightDirection.value.toArray(); }

  /* ---- where things are ---- */

  ray(x: number, y: number): { origin: THREE.Vector3; direction: THREE.Vector3 } {
    const { camera } = this.table;
    const at = new THREE.Vector3((x / this.element.clientWidth) * 2 - 1, 1 - (y / this.element.clientHeight) * 2, 0.5);
    const direction = at.unproject(camera).sub(camera.position).normalize();
    return { origin: camera.position.clone(), direction };
  }

  /** What is seen at a pixel (CSS, from the view's upper left corner). */
  hit(x: number, y: number): Hit | null {
    const { origin, direction } = this.ray(x, y);
    if (this.layer) return this.hitLayer(origin, direction);
    const { view } = this;
    let best: Hit | null = null;
    view?.parts.forEach((part, index) => {
      if (!part.mesh.visible) return;
      const from = origin.clone().sub(part.mesh.position);
      const [first, count] = part.triangles, { clip } = this.shared;
      const plane = clip.value.lengthSq() > 0 ? clip.value : null;
      const passes = plane ? (px: number, py: number, pz: number) => px * plane.x + py * plane.y + pz * plane.z <= plane.w : undefined;
      const found = meet(from, direction, view.positions, view.corners, first, count, passes);
      if (!found || (best && best.distance <= found.distance)) return;
      best = this.describe(view, part, index, found.triangle, found.distance, from, direction);
    });
    return best;
  }

  /** What of the surfaces is seen at a pixel; only: of this one alone. */
  hitSurface(x: number, y: number, only?: Surface): SurfaceHit | null {
    const { origin, direction } = this.ray(x, y);
    return this.surfaces.hit(origin, direction, only);
  }

  private describe(view: View, part: ViewPart, index: number, triangle: number, distance: number, origin: THREE.Vector3,
                   direction: THREE.Vector3): Hit {
    const where = origin.clone().addScaledVector(direction, distance);
    const normal = normalOf(view.positions, view.corners, triangle);
    const section = view.kinds[triangle] === 1, face = view.faces[triangle];
    return {
      part: index, body: part.body, triangle, point: materialPoint(view, triangle, where), world: where.clone().add(part.mesh.position),
      normal, kind: section ? 'section' : 'skin', face: section || face === 0xffffffff ? -1 : face, distance,
    };
  }

  private hitLayer(origin: THREE.Vector3, direction: THREE.Vector3): Hit | null {
    const { mesh, body } = this.layer!;
    const positions = mesh.geometry.getAttribute('position').array as Float32Array, corners = mesh.geometry.index!.array as Uint32Array;
    const found = meet(origin, direction, positions, corners, 0, corners.length / 3);
    if (!found) return null;
    const point = origin.clone().addScaledVector(direction, found.distance);
    return { part: -1, body, triangle: found.triangle, point, world: point.clone(), normal: normalOf(positions, corners, found.triangle), kind: 'layer', face: -1, distance: found.distance };
  }

  /** Length of the diagonal of all there is, its parts in one place. */
  get diagonal(): number {
    const box = this.view?.together ?? this.surfaces.box;
    return box.isEmpty() ? 1 : box.getSize(new THREE.Vector3()).length();
  }

  /** The middle of all there is, its parts in one place, and how far that reaches on either side along a direction. */
  reach(direction: THREE.Vector3): { middle: THREE.Vector3; far: number } {
    const box = this.view?.together;
    if (!box || box.isEmpty()) return { middle: new THREE.Vector3(), far: 0 };
    const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    return { middle: box.getCenter(new THREE.Vector3()),
      far: half.x * Math.abs(direction.x) + half.y * Math.abs(direction.y) + half.z * Math.abs(direction.z) };
  }

  /* ---- drawing ---- */

  invalidate(): void {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    this.wanted = false;
    if (this.slow) this.chooseFineness();
    const start = performance.now(), { camera } = this.table;
    const arm = camera.position.clone().sub(this.table.target), { up } = this.table;
    const level = arm.addScaledVector(up, -arm.dot(up)).normalize();
    if (level.lengthSq() < 0.5) level.setFromMatrixColumn(camera.matrix, 1).negate();
    const azimuth = THREE.MathUtils.degToRad(this.lightAzimuth), elevation = THREE.MathUtils.degToRad(this.lightElevation);
    this.shared.lightDirection.value.copy(level.applyAxisAngle(up, azimuth)).multiplyScalar(Math.cos(elevation)).addScaledVector(up, Math.sin(elevation));
    this.shared.upDirection.value.copy(up);
    this.floor.visible = !this.layer && this.view?.box.isEmpty() === false;
    this.ribbons.pale.value = this.layer || this.shared.mode.value === 1 ? 0.75 : 0; // where their colour is all about them
    camera.updateMatrixWorld();
    this.shared.known.value = this.sheet !== null && this.sheet.of === this.seen();
    this.renderer.render(this.scene, camera);
    if (this.within) this.drawWithin(camera);
    this.overlay.draw();
    const took = performance.now() - start;
    for (const call of this.onDraw) call(took);
  }

  /* The sections are drawn; the surfaces and, over all, what is seen through follow. */
  private drawWithin(camera: THREE.PerspectiveCamera): void {
    const { renderer, shared, view } = this, bounded = new Set(this.surfaces.shown.flatMap(({ outer, body }) => (outer ? [body] : [])));
    renderer.autoClear = false;
    this.surfaces.draw(renderer, camera, false);
    if (shared.opacity.value > 0) {
      this.surfaces.draw(renderer, camera, true);
      if (view) this.drawSkin(view, camera, bounded);
    }
    renderer.autoClear = true;
  }

  /* The skin of bodies that no surface bounds: else that is drawn in its place. */
  private drawSkin(view: View, camera: THREE.PerspectiveCamera, bounded: Set<number>): void {
    const { shared } = this, { known } = shared, kept = view.parts.map(({ mesh }) => mesh.visible), fine = known.value;
    shared.show.value = 2;
    known.value = false; // those colours are of the sections
    for (const { mesh, body } of view.parts) {
      mesh.visible &&= !bounded.has(body);
      mesh.material.transparent = true;
      mesh.material.depthWrite = false;
    }
    this.renderer.render(view.group, camera);
    view.parts.forEach(({ mesh }, i) => {
      mesh.visible = kept[i];
      mesh.material.transparent = false;
      mesh.material.depthWrite = true;
    });
    shared.show.value = 1;
    known.value = fine;
  }

  private get ratio(): number { return Math.min(window.devicePixelRatio, 2); }

  private chooseFineness(): void {
    const moving = performance.now() - this.moved < 250;
    if (moving) {
      clearTimeout(this.rest);
      this.rest = window.setTimeout(() => this.invalidate(), 300);
    }
    if (this.coarse !== moving) this.renderer.setPixelRatio((this.coarse = moving) ? this.ratio / 3 : this.ratio);
  }
  private moved = -Infinity;

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element, { ratio } = this;
    if (width === 0 || height === 0) return;
    this.coarse = false;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height);
    this.ribbons.resolution.value.set(width, height);
    this.overlay.resize(width, height, ratio);
    this.table.resize(width, height);
    this.draw();
  }

  private placeFloor(): void {
    const { view } = this;
    if (!view || view.box.isEmpty()) return;
    const { up } = this.table, size = view.box.getSize(new THREE.Vector3()), middle = view.box.getCenter(new THREE.Vector3());
    const half = 0.5 * (Math.abs(size.x * up.x) + Math.abs(size.y * up.y) + Math.abs(size.z * up.z));
    this.floor.position.copy(middle).addScaledVector(up, -1.02 * half);
    this.floor.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    this.floor.scale.setScalar(size.length());
  }

  /** The picture as it is, as a PNG. */
  picture(): Promise<Blob> {
    this.moved = -Infinity;
    this.draw();
    return new Promise((resolve, reject) => this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('no picture'))), 'image/png'));
  }
}

/* Is there no graphics card? Asked of a context of its own, because the real one is made by the answer. */
function drawsInSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return true;
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const renderer = String(gl.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(renderer);
}

/* A soft shadow under the model, so that it stands somewhere. */
function shadowOnTheFloor(): THREE.Mesh {
  const material = new THREE.ShaderMaterial({
    transparent: true, depthWrite: false,
    vertexShader: 'varying vec2 at; void main() { at = position.xy * 2.0; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }',
    fragmentShader: 'varying vec2 at; void main() { float r = length(at); gl_FragColor = vec4(0.0, 0.0, 0.0, 0.34 * pow(max(0.0, 1.0 - r), 2.0)); }',
  });
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), material);
  floor.renderOrder = -1;
  return floor;
}

/* Material coordinates of a place on a triangle of the view. */
function materialPoint(view: View, triangle: number, where: THREE.Vector3): THREE.Vector3 {
  if (view.material === view.positions) return where.clone();
  const corners = [0, 1, 2].map((k) => view.corners[3 * triangle + k]);
  const at = (from: Float32Array) => corners.map((v) => new THREE.Vector3().fromArray(from, 3 * v));
  const [a, b, c] = at(view.positions), weights = new THREE.Vector3();
  THREE.Triangle.getBarycoord(where, a, b, c, weights);
  const [p, q, r] = at(view.material);
  return p.multiplyScalar(weights.x).addScaledVector(q, weights.y).addScaledVector(r, weights.z);
}

function setGhost(part: ViewPart, ghost: Ghost | null): void {
  const { material } = part.mesh, had = 'GHOST' in material.defines;
  if (ghost) {
    const s = ghost.up.clone().normalize(), t = ghost.along.clone().addScaledVector(s, -ghost.along.dot(s)).normalize();
    const r = s.clone().cross(t);
    const frame = new THREE.Matrix4().makeBasis(r, s, t).scale(new THREE.Vector3(ghost.size, ghost.size, ghost.size));
    frame.setPosition(ghost.point.clone().addScaledVector(r, -ghost.size / 2).addScaledVector(s, -ghost.size / 2).addScaledVector(t, -ghost.size / 2));
    Object.assign(material.uniforms, {
      ghostMatrix: { value: frame.invert() }, ghost: { value: ghost.texture }, ghostMask: { value: new THREE.Vector2(ghost.radius, ghost.dropOff) },
    });
    material.defines.GHOST = 1;
  } else delete material.defines.GHOST;
  if (had !== (ghost !== null)) material.needsUpdate = true;
  material.uniformsNeedUpdate = true;
}
