// Pick parts, and pull them about. What is not a part turns the camera.

import { Plane, Vector3 } from 'three';
import type { App } from '../app';
import type { Tool, ToolEvent } from './tool';
import { toPoint } from './stroke';

export function selectTool(app: App): Tool {
  const { store, viewport, actions } = app;
  let drag: { part: number; plane: Plane; from: Vector3; offset: Vector3; moved: boolean } | null = null;

  /* Where the pointer is on the plane that faces the eye through the place first touched. */
  function onPlane(event: ToolEvent, plane: Plane): Vector3 | null {
    const { origin, direction } = event.ray();
    const slope = plane.normal.dot(direction);
    if (Math.abs(slope) < 1e-6) return null;
    return origin.addScaledVector(direction, -(plane.normal.dot(origin) + plane.constant) / slope);
  }

  function put(part: number, offset: Vector3): void {
    viewport.view!.parts[part].mesh.position.copy(offset);
    viewport.view!.parts[part].mesh.updateMatrixWorld();
    viewport.invalidate();
  }

  return {
    name: 'select', label: 'Select', key: 'v', icon: 'select',
    hint: 'Click a part to pick it, drag a picked part to pull it away. Drag beside it to turn the view, wheel to zoom, shift-drag to pan.',
    down(event) {
      const hit = event.hit(), { part } = store.state;
      // Only a part that is picked already is dragged, so that turning the view over the model stays easy.
      if (!hit || hit.part < 0 || hit.part !== part || (viewport.view?.parts.length ?? 0) < 2) {
        drag = null;
        clicked = { x: event.x, y: event.y };
        watch();
        return false;
      }
      const normal = event.ray().direction.negate();
      drag = { part: hit.part, plane: new Plane().setFromNormalAndCoplanarPoint(normal, hit.world), from: hit.world.clone(),
               offset: viewport.view!.parts[hit.part].mesh.position.clone(), moved: false };
      return true;
    },
    move(event) {
      const at = drag && onPlane(event, drag.plane);
      if (!drag || !at) return;
      drag.moved = true;
      put(drag.part, drag.offset.clone().add(at.sub(drag.from)));
    },
    up(event) {
      if (!drag) return;
      const { part, offset, from, moved, plane } = drag, at = onPlane(event, plane);
      drag = null;
      if (!moved || !at) return;
      const stated = viewport.view!.parts[part], add = at.sub(from);
      const extra = new Vector3(...stated.offset).negate().add(offset).add(add); // beyond the gaps of cuts
      const known = (store.state.document.parts ?? []).find((one: any) => one.at.every((x: number, i: number) => x === stated.inside[i]));
      if (known?.offset) extra.add(new Vector3(...(known.offset as [number, number, number])));
      void actions.apply('Move part', [{ op: 'part.move', at: stated.inside, offset: toPoint(extra) }]).then((done) => {
        if (!done) put(part, offset);
      });
    },
    cancel() {
      if (drag) put(drag.part, drag.offset);
      drag = null;
    },
  };

  var clicked: { x: number; y: number } | null;
  /* A press that the camera has is a click when it ends where it began. */
  function watch(): void {
    viewport.element.addEventListener('pointerup', (event) => {
      const place = viewport.element.getBoundingClientRect(), x = event.clientX - place.left, y = event.clientY - place.top;
      if (!clicked || Math.hypot(x - clicked.x, y - clicked.y) > 4) return;
      const hit = viewport.hit(x, y);
      store.set({ part: hit && hit.part >= 0 ? hit.part : null, ...(hit ? { body: hit.body } : {}) });
    }, { once: true });
  }
}
