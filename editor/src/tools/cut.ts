// The cutting stroke (Takayama et al. 2008, §4 and §5.1.1): drawn across the model, it sweeps a surface from the eye.

import type { App } from '../app';
import { gapOf } from '../parts';
import type { Json } from '../protocol';
import type { Tool } from './tool';
import { FlatStroke, flatDistance, simplify, toPoint } from './stroke';

export function cutTool(app: App): Tool {
  const { store, viewport, actions } = app;
  let stroke: FlatStroke | null = null;

  function show(): void {
    viewport.overlay.show('stroke', stroke ? [{ points: stroke.points, flat: true, colour: '#ffffff', width: 2, dashed: true }] : null);
  }

  /* The points lie at the distance of the target; the cut goes through all of the model along the rays. */
  function operation(points: { x: number; y: number }[], keep: string): Json {
    const distance = viewport.table.camera.position.distanceTo(viewport.table.target);
    const space = points.map(({ x, y }) => {
      const { origin, direction } = viewport.ray(x, y);
      return toPoint(origin.addScaledVector(direction, distance));
    });
    return { op: 'cut.stroke', stroke: { eye: toPoint(viewport.table.camera.position), points: space }, keep };
  }

  return {
    name: 'cut', label: 'Cut', key: 'c', icon: 'cut', shift: true,
    hint: 'Draw across the model: what lies right of the stroke stays. Shift keeps the other side, Alt both.',
    enter() { app.assemble(true); },
    leave() { app.assemble(false); },
    down(event) {
      stroke = new FlatStroke();
      stroke.add(event.x, event.y);
      return true;
    },
    move(event) {
      if (stroke?.add(event.x, event.y)) show();
    },
    up(event) {
      const drawn = stroke;
      stroke = null;
      show();
      if (!drawn || drawn.length < 12) return;
      drawn.add(event.x, event.y);
      const { keep: chosen, separate } = store.state, other = chosen === 'negative' ? 'positive' : 'negative';
      const keep = event.pointer.altKey ? 'both' : event.pointer.shiftKey ? other : chosen;
      const points = simplify(drawn.points, 0.75, flatDistance);
      app.timing.begin('cut');
      void actions.apply('Cut', [{ ...operation(points, keep), ...gapOf(app, keep), ...(separate ? { separate } : {}) }]);
      store.set({ part: null });
    },
    cancel() {
      stroke = null;
      show();
    },
  };
}
