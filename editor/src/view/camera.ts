// The camera and the hands on it: a turntable about a target, for mouse, pen and touch.

import * as THREE from 'three';
import type { Json, Point } from '../protocol';

const toVector = (point: Point | undefined, fallback: Point): THREE.Vector3 => new THREE.Vector3(...(point ?? fallback));

export class Turntable {
  readonly camera = new THREE.PerspectiveCamera(30, 1, 0.01, 100);
  readonly target = new THREE.Vector3();
  readonly up = new THREE.Vector3(0, 0, 1);
  private readonly box = new THREE.Box3(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  onChange: () => void = () => {};

  constructor() { this.lookFrom(new THREE.Vector3(0.6, -1, 0.55)); }

  /** What is seen: near and far planes, and what `frame` goes by. */
  see(box: THREE.Box3): void {
    if (box.isEmpty()) return;
    this.box.copy(box);
    this.settle();
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.onChange();
  }

  /** The camera a document states: an eye, or a direction from which everything is seen. */
  fromDocument(stated: Json | undefined): void {
    this.up.copy(toVector(stated?.up, [0, 0, 1])).normalize();
    this.camera.fov = stated?.field_of_view ?? 30;
    this.camera.updateProjectionMatrix();
    if (stated?.eye) {
      this.camera.position.copy(toVector(stated.eye, [0, 0, 1]));
      this.target.copy(toVector(stated.target, [0, 0, 0]));
      this.settle();
    } else this.lookFrom(toVector(stated?.direction, [0.6, -1, 0.55]));
  }

  /** As a document, or a picture request, states it. */
  toDocument(): Json {
    const round = (v: THREE.Vector3): Point => v.toArray().map((x) => Number(x.toPrecision(7))) as Point;
    return { eye: round(this.camera.position), target: round(this.target), up: round(this.up), field_of_view: this.camera.fov };
  }

  /** Everything in view from this direction, with an eighth of air round it (as pith_camera_fit does). */
  lookFrom(direction: THREE.Vector3, up?: THREE.Vector3): void {
    if (up) this.up.copy(up).normalize();
    const middle = this.box.getCenter(new THREE.Vector3()), away = direction.clone().normalize();
    if (Math.abs(away.dot(this.up)) > 0.9999) away.addScaledVector(this.sideways(away), 0.004).normalize();
    this.target.copy(middle);
    this.camera.position.copy(middle).add(away);
    this.aim();
    const right = new THREE.Vector3(), top = new THREE.Vector3(), back = new THREE.Vector3();
    this.camera.matrix.extractBasis(right, top, back);
    const tan = Math.tan(THREE.MathUtils.degToRad(this.camera.fov) / 2);
    let distance = 0;
    const { min, max } = this.box, corner = new THREE.Vector3();
    for (let i = 0; i < 8; ++i) {
      corner.set(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z).sub(middle);
      const across = Math.abs(corner.dot(right)) / this.camera.aspect, along = Math.abs(corner.dot(top));
      distance = Math.max(distance, corner.dot(back) + (1.125 * Math.max(across, along)) / tan);
    }
    this.camera.position.copy(middle).addScaledVector(back, distance);
    this.settle();
  }

  frame(): void { this.lookFrom(this.camera.position.clone().sub(this.target)); }

  orbit(dx: number, dy: number): void {
    const arm = this.camera.position.clone().sub(this.target);
    const side = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0);
    arm.applyAxisAngle(this.up, -dx);
    side.applyAxisAngle(this.up, -dx);
    const angle = arm.angleTo(this.up), turned = THREE.MathUtils.clamp(angle - dy, 0.01, Math.PI - 0.01);
    arm.applyAxisAngle(side, turned - angle);
    this.camera.position.copy(this.target).add(arm);
    this.settle();
  }

  /** Moves target and eye with the pointer; pixels of a view `height` high. */
  pan(dx: number, dy: number, height: number): void {
    const distance = this.camera.position.distanceTo(this.target);
    const unit = (2 * distance * Math.tan(THREE.MathUtils.degToRad(this.camera.fov) / 2)) / height;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0);
    const top = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    const move = right.multiplyScalar(-dx * unit).addScaledVector(top, dy * unit);
    this.camera.position.add(move);
    this.target.add(move);
    this.settle();
  }

  /** Nearer by a factor below 1; `towards`, a point of the world, stays under the pointer. */
  zoom(factor: number, towards?: THREE.Vector3): void {
    const size = this.box.getSize(new THREE.Vector3()).length();
    const distance = this.camera.position.distanceTo(this.target) * factor;
    if (distance < size * 1e-3 || distance > size * 50) return;
    if (towards) this.target.lerp(towards, 1 - factor);
    const arm = this.camera.position.clone().sub(towards ?? this.target).multiplyScalar(factor);
    this.camera.position.copy(towards ?? this.target).add(arm);
    this.settle();
  }

  /** The point at the target's distance that is seen at x, y: from -1 to 1 across the view and upwards. */
  beside(x: number, y: number): THREE.Vector3 {
    const right = new THREE.Vector3(), top = new THREE.Vector3(), back = new THREE.Vector3();
    this.camera.matrix.extractBasis(right, top, back);
    const half = this.camera.position.distanceTo(this.target) * Math.tan(THREE.MathUtils.degToRad(this.camera.fov) / 2);
    return this.target.clone().addScaledVector(right, x * half * this.camera.aspect).addScaledVector(top, y * half);
  }

  private sideways(direction: THREE.Vector3): THREE.Vector3 {
    const other = Math.abs(direction.y) < 0.9 ? new THREE.Vector3(0, -1, 0) : new THREE.Vector3(1, 0, 0);
    return other.addScaledVector(direction, -other.dot(direction)).normalize();
  }

  private aim(): void {
    this.camera.up.copy(this.up);
    this.camera.lookAt(this.target);
    this.camera.updateMatrix();
    this.camera.updateMatrixWorld();
  }

  private settle(): void {
    this.aim();
    const radius = this.box.getSize(new THREE.Vector3()).length() * 0.5 + 1e-9;
    const distance = this.camera.position.distanceTo(this.box.getCenter(new THREE.Vector3()));
    this.camera.near = Math.max(distance - 3 * radius, radius * 2e-3);
    this.camera.far = distance + 3 * radius;
    this.camera.updateProjectionMatrix();
    this.onChange();
  }
}

/** What drags do to the camera while no tool has them: one finger or button orbits, two fingers pan and zoom. */
export class Hands {
  private readonly down = new Map<number, { x: number; y: number }>();
  private pan = false;

  constructor(private readonly table: Turntable, private readonly element: HTMLElement,
              private readonly under: (x: number, y: number) => THREE.Vector3 | undefined) {}

  get fingers(): number { return this.down.size; }

  press(event: PointerEvent): void {
    this.down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.pan = event.button === 1 || event.shiftKey || (event.pointerType === 'mouse' && event.button === 2 && event.ctrlKey);
  }

  drag(event: PointerEvent): void {
    const at = this.down.get(event.pointerId);
    if (!at) return;
    const dx = event.clientX - at.x, dy = event.clientY - at.y;
    const other = [...this.down.entries()].find(([id]) => id !== event.pointerId)?.[1];
    this.down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (other) {
      // About the middle between the fingers, so that the order in which they are told of does not matter.
      const before = Math.hypot(at.x - other.x, at.y - other.y), now = Math.hypot(event.clientX - other.x, event.clientY - other.y);
      const { left, top, width, height } = this.element.getBoundingClientRect();
      const x = ((at.x + other.x) / 2 - left) / width, y = ((at.y + other.y) / 2 - top) / height;
      if (before > 10 && now > 10) this.table.zoom(before / now, this.table.beside(2 * x - 1, 1 - 2 * y));
      this.table.pan(dx / 2, dy / 2, height);
    } else if (this.pan) this.table.pan(dx, dy, this.element.clientHeight);
    else this.table.orbit((dx * Math.PI) / this.element.clientHeight, (dy * Math.PI) / this.element.clientHeight);
  }

  release(event: PointerEvent): void { this.down.delete(event.pointerId); }

  wheel(event: WheelEvent, x: number, y: number): void {
    const step = event.deltaMode === 1 ? 30 : 1;
    if (event.shiftKey) this.table.pan(-event.deltaX * step, -event.deltaY * step, this.element.clientHeight);
    else this.table.zoom(Math.exp(THREE.MathUtils.clamp(event.deltaY * step, -200, 200) * 0.0015), this.under(x, y));
  }
}
