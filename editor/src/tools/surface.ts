// Painting on surfaces that colours flow from, and taking parts of them away (Takayama's thesis 2011, §6.3.1 and §6.3.3).

import { Matrix4, Vector3 } from 'three';
import type { App } from '../app';
import { meetVertices, sideOfStroke } from '../brush';
import type { Json, Point } from '../protocol';
import { bodyJson, surfaceKey, surfacePath, surfacesOf, type State, type ViewMode } from '../store';
import { twoSidedOperations } from '../surfaceview';
import type { Coat, Surface, SurfaceHit } from '../view/surfaces';
import { FlatStroke, flatDistance, simplify, spaceDistance, toPoint, type FlatPoint } from './stroke';
import type { Tool, ToolEvent } from './tool';

/* Surfaces are worked on where they are seen. */
function showSurfaces(app: App): { enter(): void; leave(): void } {
  let before: ViewMode | null = null;
  return {
    enter() {
      const { mode } = app.store.state;
      before = mode === 'surfaces' ? null : mode;
      if (before) app.store.set({ mode: 'surfaces' });
    },
    leave() {
      if (before && app.store.state.mode === 'surfaces') app.store.set({ mode: before });
    },
  };
}

const surfaceJson = (state: State, body: number, name: string): Json | undefined =>
  surfacesOf(state, body).find((surface) => surface.name === name);

/** The radius of the brush, model units; as long as none was chosen, one that suits the model. */
export function brushRadius({ store, viewport }: App): number {
  return store.state.paintRadius || Number((viewport.diagonal / 40).toPrecision(2));
}

/* Bodies stand where "place" says: from there to where their surfaces were drawn. */
function unplaced(state: State, body: number): Matrix4 {
  const { scale = 1, turn_x = 0, turn_y = 0, turn_z = 0, move_x = 0, move_y = 0, move_z = 0 } = bodyJson(state, body).shape?.place ?? {};
  const turned = new Matrix4(), about = (made: Matrix4): void => { turned.premultiply(made); };
  about(new Matrix4().makeScale(scale, scale, scale));
  about(new Matrix4().makeRotationX((turn_x * Math.PI) / 180));
  about(new Matrix4().makeRotationY((turn_y * Math.PI) / 180));
  about(new Matrix4().makeRotationZ((turn_z * Math.PI) / 180));
  about(new Matrix4().makeTranslation(move_x, move_y, move_z));
  return turned.invert();
}

/* ---- paint ------------------------------------------------------------------------------------------------------- */

interface Painting {
  surface: Surface;
  index: number;                    // of the surface in the document
  points: Point[];                  // of the brush, where the surface was drawn
  radius: number;                   // there
  coat: Coat;
  x: number;
  y: number;
}

/** Paints colours or blur along a drag over a surface. */
export function paintSurfaceTool(app: App): Tool {
  const { store, viewport, actions } = app, looks = showSurfaces(app);
  let painting: Painting | null = null;

  function ring(hit: SurfaceHit | null): void {
    viewport.brush(hit?.point ?? null, brushRadius(app), hit?.normal);
  }

  function begin(event: ToolEvent): Painting | null {
    const hit = viewport.hitSurface(event.x, event.y);
    if (!hit) return null;
    const { surface } = hit, { body, name } = surface, { state } = store;
    const index = surfacesOf(state, body).findIndex((each) => each.name === name);
    if (index < 0) return null;
    const { paintWhat, paintSide, paintColour, paintBlur } = state, colour = paintWhat === 'colour';
    const one = !surface.twoSided && paintSide === 'both';
    const coat: Coat = { body, name, vertices: new Set(), until: null, blur: colour ? null : paintBlur,
      front: colour && paintSide !== 'back' ? paintColour : null,
      back: colour && (one || paintSide !== 'front') ? paintColour : null };
    store.set({ body, selectedSurface: name, paintRadius: brushRadius(app) });
    viewport.surfaces.begin(coat);
    return { surface, index, points: [], radius: brushRadius(app) * hit.surface.drawnScale(hit.triangle), coat, x: event.x,
      y: event.y };
  }

  function take(x: number, y: number): void {
    if (!painting) return;
    const { surface, points, radius, coat } = painting, hit = viewport.hitSurface(x, y, surface);
    if (!hit) return;
    const { paintRepeat: repeat, body } = store.state, folds = Number(bodyJson(store.state, body).sketch?.folds ?? 0);
    const met: number[] = [];
    meetVertices(surface.drawn, points.at(-1) ?? hit.drawn, hit.drawn, { radius, repeat, folds }, (vertex) => met.push(vertex));
    points.push(hit.drawn);
    viewport.surfaces.extend(coat, met);
    viewport.invalidate();
  }

  /* What the stroke is to the document: one operation, and before it what gives each side a colour of its own. */
  function operations({ surface, index, points, radius }: Painting): Json[] {
    const { state } = store, { paintWhat, paintSide, paintColour, paintBlur, paintRepeat } = state;
    const json = surfacesOf(state, surface.body)[index];
    const round = (point: Point): Point => point.map((each) => Number(each.toPrecision(6))) as Point;
    const vectors = points.map((point) => new Vector3(...point));
    const corners = simplify(vectors, 0.05 * radius, spaceDistance).map(toPoint).map(round);
    const brush = { points: corners, radius: Number(radius.toPrecision(4)), ...(paintRepeat === 'once' ? {} : { repeat: paintRepeat }) };
    const paint: Json = { op: 'surface.paint', ...surfaceKey(state, surface.body), surface: surface.name, brush };
    if (paintWhat === 'blur') return [{ ...paint, blur: paintBlur }];
    const before = paintSide === 'both' ? [] : twoSidedOperations(json, surfacePath(state, index, surface.body));
    if (paintSide !== 'back') paint.front = paintColour;
    if (paintSide === 'back' || (paintSide === 'both' && surface.twoSided)) paint.back = paintColour;
    return [...before, paint];
  }

  return {
    name: 'paint-surface', label: 'Paint surfaces', key: 'q', icon: 'brush',
    hint: 'Drag over a surface to paint its colours or its blur. Alt and the wheel set how wide the brush is.',
    enter: looks.enter,
    leave() {
      ring(null);
      looks.leave();
    },
    down(event) {
      painting = begin(event);
      take(event.x, event.y);
      return painting !== null;
    },
    move(event) {
      if (!painting) return;
      // A quick hand leaves out what lies between two events; it is looked for on the way.
      const dx = event.x - painting.x, dy = event.y - painting.y, steps = Math.min(12, Math.floor(Math.hypot(dx, dy) / 6));
      for (let i = 1; i < steps; ++i) take(painting.x + (dx * i) / steps, painting.y + (dy * i) / steps);
      take(event.x, event.y);
      painting.x = event.x;
      painting.y = event.y;
      ring(viewport.hitSurface(event.x, event.y, painting.surface));
    },
    hover(event) { ring(viewport.hitSurface(event.x, event.y)); },
    up() {
      const done = painting;
      painting = null;
      if (!done) return;
      if (store.state.paintWhat === 'colour') remember(app, store.state.paintColour);
      void actions.apply(store.state.paintWhat === 'blur' ? 'Paint blur' : 'Paint surface', operations(done))
        .then((taken) => {
          viewport.surfaces.end(done.coat, taken ? store.state.revision : null);
          viewport.invalidate();
        });
    },
    wheel(event, delta) {
      if (!event.pointer.altKey) return false;
      store.set({ paintRadius: Number((brushRadius(app) * Math.exp(-delta * 0.001)).toPrecision(3)) });
      ring(viewport.hitSurface(event.x, event.y));
      return true;
    },
    cancel() {
      if (painting) viewport.surfaces.end(painting.coat, null);
      painting = null;
      viewport.invalidate();
    },
  };
}

/* Colours painted last come first; a dozen are kept. */
function remember({ store }: App, colour: string): void {
  store.set({ recentColours: [colour, ...store.state.recentColours.filter((other) => other !== colour)].slice(0, 12) });
}

/* ---- erasing ----------------------------------------------------------------------------------------------------- */

/** Takes a part of the chosen surface away: a stroke over the picture, and then a click on what goes. */
export function eraseSurfaceTool(app: App): Tool {
  const { store, viewport, actions, messages } = app, looks = showSurfaces(app);
  let stroke: FlatStroke | null = null;
  let waiting: { points: FlatPoint[]; surface: Surface; operation: Json } | null = null;

  function show(): void {
    const points = stroke?.points ?? waiting?.points;
    viewport.overlay.show('stroke', points ? [{ points, flat: true, colour: '#ffffff', width: 2, dashed: true }] : null);
  }

  function forget(): void {
    waiting?.surface.mark(null);
    waiting = null;
    stroke = null;
    show();
    viewport.invalidate();
    store.set({ hint: tool.hint });
  }

  /* The chosen surface; where none is, or is in sight, that under the stroke. */
  function meant(points: FlatPoint[]): Surface | null {
    const { body, selectedSurface } = store.state, chosen = viewport.surfaces.find(body, selectedSurface);
    if (chosen?.mesh.visible) return chosen;
    for (const { x, y } of points) {
      const hit = viewport.hitSurface(x, y);
      if (hit) return hit.surface;
    }
    return null;
  }

  /* As cuts are written: points on the rays, where the surface was drawn. */
  function begin(points: FlatPoint[]): void {
    const surface = meant(points), { state } = store;
    if (!surface) return void messages.say('Draw over a surface, or choose one in the list first.');
    const json = surfaceJson(state, surface.body, surface.name);
    if (json?.kind === 'grains') return void messages.say('Grains lie where their region says; erase the surface they lie on instead.');
    store.set({ body: surface.body, selectedSurface: surface.name });
    const back = json?.kind === 'body' ? new Matrix4() : unplaced(state, surface.body), { camera, target } = viewport.table;
    const distance = camera.position.distanceTo(target);
    const space = points.map(({ x, y }) => {
      const { origin, direction } = viewport.ray(x, y);
      return toPoint(origin.addScaledVector(direction, distance).applyMatrix4(back));
    });
    const operation = { op: 'surface.erase', ...surfaceKey(state, surface.body), surface: surface.name,
      stroke: { eye: toPoint(camera.position.clone().applyMatrix4(back)), points: space } };
    if (state.eraseSide !== 'click') return erase(operation, state.eraseSide);
    waiting = { points, surface, operation };
    store.set({ hint: 'Now click on the part that goes; Escape keeps all.' });
    show();
  }

  function erase(operation: Json, side: 'right' | 'left'): void {
    forget();
    void actions.apply('Erase surface', [{ ...operation, side: side === 'right' ? 'positive' : 'negative' }]);
  }

  /* Shows which part would go. */
  function mark(side: 'right' | 'left' | null): void {
    if (!waiting) return;
    const { points, surface } = waiting, { camera } = viewport.table, at = new Vector3();
    const { clientWidth, clientHeight } = viewport.element;
    surface.mark(side && ((x, y, z) => {
      at.set(x, y, z).project(camera);
      return sideOfStroke(points, (at.x + 1) * 0.5 * clientWidth, (1 - at.y) * 0.5 * clientHeight) === side;
    }));
    viewport.invalidate();
  }

  const tool: Tool = {
    name: 'erase-surface', label: 'Erase surfaces', key: 'w', icon: 'erase',
    hint: 'Draw across the chosen surface, then click on the part that goes.',
    enter: looks.enter,
    leave() {
      forget();
      looks.leave();
    },
    down(event) {
      if (waiting) return true;
      stroke = new FlatStroke();
      stroke.add(event.x, event.y);
      return true;
    },
    move(event) {
      if (stroke?.add(event.x, event.y)) show();
    },
    hover(event) {
      if (waiting) mark(sideOfStroke(waiting.points, event.x, event.y));
    },
    up(event) {
      if (waiting) return erase(waiting.operation, sideOfStroke(waiting.points, event.x, event.y));
      const drawn = stroke;
      stroke = null;
      show();
      if (!drawn || drawn.length < 12) return;
      drawn.add(event.x, event.y);
      begin(simplify(drawn.points, 0.75, flatDistance));
    },
    cancel: forget,
    pending: () => waiting !== null,
  };
  // The stroke is of one picture: where the camera has moved on it means another.
  const moved = viewport.table.onChange;
  viewport.table.onChange = () => {
    moved();
    if (waiting) forget();
  };
  return tool;
}
