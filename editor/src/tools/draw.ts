// Strokes and points in the body: of one depth (2008, §4.3; thesis §4.4.1), and those that directions follow (§4.3.1,
// §4.4.1). Drawn on the skin, on sections and on layers.

import type { Vector3 } from 'three';
import type { App } from '../app';
import type { Json } from '../protocol';
import { bodyKey } from '../store';
import { paletteCss } from '../view/looks';
import { FlatStroke, simplify, spaceDistance, toPoint } from './stroke';
import { directionList } from './table';
import type { Hit, Tool, ToolEvent } from './tool';

interface Drawing { flat: FlatStroke; points: Vector3[]; hit: Hit }

/* What both stroke tools do: follow the pointer over the body it began on, and hand the corners over at the end. */
function strokeTool(app: App, facts: Pick<Tool, 'name' | 'label' | 'key' | 'icon' | 'hint'>, how: {
  colour(): string; arrow?: boolean; begin(hit: Hit): boolean; finish(points: [number, number, number][],
    hit: Hit): void; sameKind: boolean;
}): Tool {
  const { store, viewport } = app;
  let drawing: Drawing | null = null;

  function show(): void {
    viewport.overlay.show('stroke', drawing
      && [{ points: drawing.flat.points, flat: true, colour: how.colour(), width: 3.5, arrow: how.arrow }]);
  }
  function take(event: ToolEvent): void {
    const hit = event.hit();
    if (!drawing || !hit || hit.body !== drawing.hit.body || (how.sameKind && hit.kind !== drawing.hit.kind)) return;
    if (drawing.flat.add(event.x, event.y)) drawing.points.push(hit.point.clone());
  }
  return {
    ...facts,
    down(event) {
      const hit = event.hit();
      if (!hit || !how.begin(hit)) return false;
      store.set({ body: hit.body });
      drawing = { flat: new FlatStroke(), points: [], hit };
      take(event);
      return true;
    },
    move(event) {
      take(event);
      show();
    },
    up() {
      const drawn = drawing;
      drawing = null;
      show();
      if (!drawn || drawn.points.length < 2 || drawn.flat.length < 8) return;
      how.finish(simplify(drawn.points, 0.002 * viewport.diagonal, spaceDistance).map(toPoint), drawn.hit);
    },
    cancel() {
      drawing = null;
      show();
    },
  };
}

/** Draws strokes of the chosen depth. */
export function depthTool(app: App): Tool {
  const { store, actions } = app;
  return strokeTool(app, {
    name: 'depth', label: 'Depth stroke', key: 'd', icon: 'depth',
    hint: 'Draw a stroke of the chosen depth on the skin, a section or a layer; 1 marks the core.',
  }, {
    colour: () => paletteCss(store.state.paint), sameKind: false, begin: () => true,
    finish(points, hit) {
      const { paint } = store.state;
      void actions.apply(`Depth stroke ${paint}`,
        [{ op: 'depth.stroke', ...bodyKey(store.state, hit.body), points, depth: paint }]);
    },
  });
}

/** Draws strokes that the fibres follow: within the layers, or, for type 0-B, a vector field. */
export function directionTool(app: App): Tool {
  const { store, actions, messages } = app;
  return strokeTool(app, {
    name: 'direction', label: 'Direction', key: 'g', icon: 'direction',
    hint: 'Draw along the fibres: on the skin, on sections, or on layers; Alt and the wheel go through the layers.',
  }, {
    colour: () => '#ffffff', arrow: true, sameKind: true,
    begin(hit) {
      if (directionList({ ...store.state, body: hit.body }, hit.kind)) return true;
      messages.say('The texture of this body follows no directions.');
      return false;
    },
    finish(points, hit) {
      const list = directionList({ ...store.state, body: hit.body }, hit.kind)!;
      const op = list === 'direction' ? 'direction.stroke' : list;
      void actions.apply(list === 'direction' ? 'Direction stroke' : 'Vector stroke',
        [{ op, ...bodyKey(store.state, hit.body), points }]);
    },
  });
}

/** Places points of the chosen depth. */
export function pointsTool(app: App): Tool {
  const { store, actions, viewport } = app;
  let pressed: Hit | null = null;

  function show(hit: Hit | null): void {
    const { paint } = store.state;
    viewport.overlay.show('point', hit
      && [{ points: [hit.world], colour: paletteCss(paint), dots: 6, label: String(paint) }]);
  }
  return {
    name: 'points', label: 'Depth points', key: 'o', icon: 'points',
    hint: 'Click to place a point of the chosen depth; drag before letting go to put it elsewhere.',
    leave: () => show(null),
    down(event) {
      pressed = event.hit();
      show(pressed);
      return pressed !== null;
    },
    move(event) {
      const hit = event.hit();
      if (hit && hit.body === pressed?.body) pressed = hit;
      show(pressed);
    },
    hover: (event) => show(event.hit()),
    up() {
      const hit = pressed, { paint } = store.state;
      pressed = null;
      show(null);
      if (!hit) return;
      store.set({ body: hit.body });
      const operation: Json = { op: 'depth.points', ...bodyKey(store.state, hit.body), points: [toPoint(hit.point)],
        depth: paint };
      void actions.apply(`Depth point ${paint}`, [operation]);
    },
    cancel() {
      pressed = null;
      show(null);
    },
  };
}
