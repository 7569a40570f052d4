// The clip plane: dragged through the model, it shows the section at once; Enter or a double click makes it a cut.

import * as THREE from 'three';
import type { App } from '../app';
import { gapOf } from '../parts';
import type { Packet } from '../protocol';
import type { Tool, ToolEvent } from './tool';
import { toPoint } from './stroke';

export interface PlaneTool extends Tool {
  /** Sets the plane's normal, keeping its place; the cut's positive side, which goes away, is where it points. */
  turn(normal: THREE.Vector3): void;
  flip(): void;
  commit(keep: 'negative' | 'both'): void;
}

type Grip = 'slide' | 'turn';

export function planeTool(app: App): PlaneTool {
  const { store, viewport, actions } = app;
  const point = new THREE.Vector3(), normal = new THREE.Vector3(0, 0, 1);
  let placed = false, active = false, asking = false, again = false, generation = 0;
  let fromVolume = false;                // was that view left for this tool?
  let grip: Grip | null = null, from = { x: 0, y: 0 }, before = new THREE.Vector3();

  const radius = (): number => 0.5 * viewport.diagonal;
  /* The plane's distance from the middle of the model, along its normal. */
  const away = (): number => point.clone().sub(viewport.reach(normal).middle).dot(normal);
  /* Where the handle is: the middle of the model, on the plane. */
  const centre = (): THREE.Vector3 => viewport.reach(normal).middle.addScaledVector(normal, away());
  const tip = (): THREE.Vector3 => centre().addScaledVector(normal, 0.45 * radius());

  /* A plane beyond the model would cut all of it away, or nothing: it is held a little inside. */
  function hold(): void {
    const most = 0.98 * viewport.reach(normal).far, held = THREE.MathUtils.clamp(away(), -most, most);
    point.addScaledVector(normal, held - away());
  }

  function place(): void {
    const { camera, target } = viewport.table;
    const view = camera.position.clone().sub(target).normalize();
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => new THREE.Vector3(...(axis as [number, number, number])));
    const nearest = axes.reduce((best, axis) => (Math.abs(axis.dot(view)) > Math.abs(best.dot(view)) ? axis : best));
    normal.copy(nearest).multiplyScalar(Math.sign(nearest.dot(view)) || 1);
    point.copy(viewport.reach(normal).middle);
    placed = true;
  }

  function outline(): void {
    if (!active) {
      viewport.overlay.show('plane', null);
      return;
    }
    const side = new THREE.Vector3(Math.abs(normal.x) < 0.8 ? 1 : 0, Math.abs(normal.x) < 0.8 ? 0 : 1, 0);
    const u = side.cross(normal).normalize(), v = normal.clone().cross(u), size = 0.62 * radius(), middle = centre();
    const corner = (a: number, b: number) => middle.clone().addScaledVector(u, a * size).addScaledVector(v, b * size);
    const accent = '#f5b942';
    viewport.overlay.show('plane', [
      { points: [corner(1, 1), corner(-1, 1), corner(-1, -1), corner(1, -1)], colour: accent, width: 1.5, closed: true, fill: 'rgb(245 185 66 / 0.06)' },
      { points: [middle, tip()], colour: accent, width: 2, arrow: true },
      { points: [tip()], colour: accent, dots: 7 }, { points: [middle], colour: accent, dots: 4 },
    ]);
  }

  /* One request at a time; what moved meanwhile is asked for again. Clip and section change together. */
  async function refresh(): Promise<void> {
    hold();
    outline();
    if (asking) {
      again = true;
      return;
    }
    asking = true;
    const mine = generation, plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, point);
    try {
      const packet = await app.connection.ask<Packet>('section', { plane: { point: toPoint(point), normal: toPoint(normal) } });
      if (mine === generation && active) viewport.preview(packet, plane);
    } catch (reason) {
      if (active) viewport.preview(null, plane);
    }
    asking = false;
    if (again) {
      again = false;
      if (active) void refresh();
    }
  }

  function close(): void {
    active = false;
    ++generation;
    viewport.preview(null, null);
    outline();
  }

  function gripAt(event: ToolEvent): Grip | null {
    const at = viewport.overlay.project(tip());
    if (at && Math.hypot(event.x - at.x, event.y - at.y) < 16) return 'turn';
    const { origin, direction } = event.ray(), slope = normal.dot(direction);
    if (Math.abs(slope) < 1e-6) return null;
    const where = origin.addScaledVector(direction, normal.dot(point.clone().sub(origin)) / slope);
    return where.distanceTo(centre()) < 0.88 * radius() ? 'slide' : null;
  }

  /* How far along the normal a pixel's step goes. */
  function slide(event: ToolEvent): void {
    const a = viewport.overlay.project(before), b = viewport.overlay.project(before.clone().addScaledVector(normal, 0.1 * radius()));
    if (!a || !b) return;
    const dx = b.x - a.x, dy = b.y - a.y, square = Math.max(dx * dx + dy * dy, 100);
    const steps = ((event.x - from.x) * dx + (event.y - from.y) * dy) / square;
    point.copy(before).addScaledVector(normal, THREE.MathUtils.clamp(0.1 * radius() * steps, -2 * radius(), 2 * radius()));
  }

  /* The normal points where the pointer is on a sphere about the handle's foot, the half towards the eye. */
  function turnTo(event: ToolEvent): void {
    const middle = before, reach = 0.45 * radius(), { origin, direction } = event.ray();
    const to = middle.clone().sub(origin), along = to.dot(direction), gap = to.lengthSq() - along * along;
    const where = origin.clone().addScaledVector(direction, along - Math.sqrt(Math.max(0, reach * reach - gap)));
    const turned = where.sub(middle).normalize();
    for (const axis of [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)]) {
      if (Math.abs(turned.dot(axis)) > 0.998) turned.copy(axis.multiplyScalar(Math.sign(turned.dot(axis)))); // snaps
    }
    normal.copy(turned);
    point.copy(middle);
  }

  store.on(['mode'], () => {
    if (active && store.state.mode === 'volume') app.messages.say('The volume view does not show the clip plane; Solid does.');
  });
  viewport.onView.push(() => { if (active) void refresh(); });

  return {
    name: 'plane', label: 'Clip plane', key: 'x', icon: 'plane',
    hint: 'Drag the plane through the model, its knob to turn it. Enter or a double click cuts there; Escape leaves it whole.',
    enter() {
      app.assemble(true);
      fromVolume = store.state.mode === 'volume'; // which shows the model seen through, not what a plane lays open
      if (fromVolume) store.set({ mode: 'solid' });
      if (!placed) place();
      else if (Math.abs(away()) > viewport.reach(normal).far) point.copy(viewport.reach(normal).middle);
      active = true;
      void refresh();
    },
    leave() {
      close();
      if (fromVolume && store.state.mode === 'solid') store.set({ mode: 'volume' });
      app.assemble(false);
    },
    down(event) {
      grip = gripAt(event);
      from = { x: event.x, y: event.y };
      before = grip === 'turn' ? centre() : point.clone();
      return grip !== null;
    },
    move(event) {
      if (grip === 'slide') slide(event);
      else if (grip === 'turn') turnTo(event);
      void refresh();
    },
    up() { grip = null; },
    wheel(event, delta) {
      if (!event.pointer.shiftKey) return false;
      point.addScaledVector(normal, -Math.sign(delta) * 0.01 * radius());
      void refresh();
      return true;
    },
    double() { this.commit('negative'); },
    cancel() { grip = null; },
    turn(towards) {
      normal.copy(towards).normalize();
      void refresh();
    },
    flip() {
      normal.negate();
      void refresh();
    },
    commit(keep) {
      app.timing.begin('plane');
      const operation = { op: 'cut.plane', plane: { point: toPoint(point), normal: toPoint(normal) }, keep, ...gapOf(app, keep) };
      store.set({ tool: 'select' });
      void actions.apply('Cut along a plane', [operation]);
    },
  };
}
