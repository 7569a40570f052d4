// Painting depth on faces (Takayama et al. 2008, §4.3): many at once up to creases, or single ones along a drag.

import type { App } from '../app';
import { Reach } from '../reach';
import { bodyKey, type ViewMode } from '../store';
import type { BodyMesh } from '../view/parts';
import type { Hit, Tool, ToolEvent } from './tool';

/* Paint shows on clay, and beside the computed depth; not over the solid. */
function showPaint(app: App): { enter(): void; leave(): void } {
  let before: ViewMode | null = null;
  return {
    enter() {
      const { mode } = app.store.state;
      before = mode === 'solid' || mode === 'volume' || mode === 'surfaces' ? mode : null;
      if (before) app.store.set({ mode: 'shape' });
    },
    leave() {
      if (before && app.store.state.mode === 'shape') app.store.set({ mode: before });
    },
  };
}

/* The face of the skin under the pointer; says so when it is a section that was hit. */
function skinFace(app: App, event: ToolEvent): Hit | null {
  const hit = event.hit();
  if (!hit) return null;
  if (hit.face < 0) {
    app.messages.say('Only the skin can be painted; draw strokes on sections and layers.');
    return null;
  }
  app.store.set({ body: hit.body });
  return hit;
}

const shownDepth = (app: App): number => (app.store.state.erase ? -1 : app.store.state.paint);

/* Shows what the server knows again, when it refused. */
function restore(app: App, body: number): void {
  const mesh = app.viewport.meshes.get(body), facts = app.model.meshes.get(body);
  if (!mesh || !facts) return;
  mesh.painted.set(facts.painted);
  app.viewport.view?.repaint(body, mesh.repaint());
  app.viewport.invalidate();
}

/** The multi-face fill: a click paints what is reached without crossing a crease. */
export function fillTool(app: App): Tool {
  const { store, viewport } = app, looks = showPaint(app);
  const known = new WeakMap<Uint32Array, Reach>();
  let pressed: { hit: Hit; faces: number[] } | null = null;

  function reached(mesh: BodyMesh, face: number): number[] {
    const reach = known.get(mesh.triangles) ?? new Reach(mesh.positions, mesh.triangles);
    known.set(mesh.triangles, reach);
    return reach.from(face, mesh.painted, store.state.crease);
  }

  return {
    name: 'fill', label: 'Fill faces', key: 'p', icon: 'fill',
    hint: 'Click a face: it is painted, and what is reached from it over faces of its depth without crossing a crease.',
    enter: looks.enter,
    leave: looks.leave,
    down(event) {
      const hit = skinFace(app, event), mesh = hit && viewport.meshes.get(hit.body);
      if (!hit || !mesh) return false;
      pressed = { hit, faces: reached(mesh, hit.face) };
      viewport.paint(hit.body, pressed.faces, shownDepth(app));
      return true;
    },
    up() {
      if (!pressed) return;
      const { hit, faces } = pressed, { erase, paint, crease } = store.state, body = bodyKey(store.state, hit.body);
      pressed = null;
      const operation = erase ? { op: 'depth.erase', ...body, faces }
        : { op: 'depth.fill', ...body, face: hit.face, depth: paint, crease };
      void app.actions.apply(erase ? 'Wipe faces' : 'Fill faces',
        [operation]).then((done) => { if (!done) restore(app, hit.body); });
    },
    cancel() {
      if (pressed) restore(app, pressed.hit.body);
      pressed = null;
    },
  };
}

/** The single-face fill: a click paints a triangle, a drag paints on. */
export function faceTool(app: App): Tool {
  const { store, viewport } = app, looks = showPaint(app);
  let drag: { body: number; faces: Set<number>; x: number; y: number } | null = null;

  function paintAt(hit: Hit | null): void {
    if (!drag || !hit || hit.body !== drag.body || hit.face < 0 || drag.faces.has(hit.face)) return;
    drag.faces.add(hit.face);
    viewport.paint(hit.body, [hit.face], shownDepth(app));
  }

  return {
    name: 'face', label: 'Paint faces', key: 'b', icon: 'face',
    hint: 'Click a triangle to paint it, or drag over several.',
    enter: looks.enter,
    leave: looks.leave,
    down(event) {
      const hit = skinFace(app, event);
      if (!hit) return false;
      drag = { body: hit.body, faces: new Set(), x: event.x, y: event.y };
      paintAt(hit);
      return true;
    },
    move(event) {
      if (!drag) return;
      // A quick hand skips triangles between two events; they are looked for on the way.
      const dx = event.x - drag.x, dy = event.y - drag.y, steps = Math.min(8, Math.floor(Math.hypot(dx, dy) / 6));
      for (let i = 1; i < steps; ++i) paintAt(viewport.hit(drag.x + (dx * i) / steps, drag.y + (dy * i) / steps));
      paintAt(event.hit());
      drag.x = event.x;
      drag.y = event.y;
    },
    up() {
      if (!drag) return;
      const { body, faces } = drag, { erase, paint } = store.state, list = [...faces].sort((a, b) => a - b);
      drag = null;
      const operation = erase ? { op: 'depth.erase', faces: list } : { op: 'depth.face', faces: list, depth: paint };
      void app.actions.apply(erase ? 'Wipe faces' : 'Paint faces', [{ ...operation, ...bodyKey(store.state, body) }])
        .then((done) => { if (!done) restore(app, body); });
    },
    cancel() {
      if (drag) restore(app, drag.body);
      drag = null;
    },
  };
}
