// The other tools of the panes: erasing with a cutting stroke, taking colours from the picture, laying the picture.

import { chosenSurface, surfaceKey } from '../store';
import { clearLine, dot, line } from './draw';
import { distance, isInside, isPositive, pointsOf, Spline, type Vec } from './curve';
import { sketchPath } from './drawn';
import { drawTool } from './drawing';
import { bendTool, editTool, smoothTool } from './editing';
import { fitStroke, isLoop, tidy } from './fit';
import { pickColour, type Pane } from './pane';
import type { CutStroke, Session } from './session';
import type { PaneEvent, PaneTool } from './tool';
import type { Json } from '../protocol';

/** All tools, in their order. */
export function paneTools(session: Session): PaneTool[] {
  return [drawTool(session), editTool(session), bendTool(session), smoothTool(session), eraseTool(session), pickTool(),
    pictureTool(session)];
}

/* ---- erasing ---------------------------------------------------------------------------------------------------------- */

/** Erases what lies on the side of the waiting stroke that the hand is on. */
export function eraseSide(session: Session, positive: boolean): void {
  const { cut } = session.values, { state } = session.app.store;
  if (!cut) return;
  session.set({ cut: null });
  void session.apply(`Erase part of ${cut.surface}`, [{ op: 'surface.erase', ...surfaceKey(state), surface: cut.surface,
    [cut.pane]: pointsOf(cut.knots), ...(cut.closed ? { closed: true } : {}), side: positive ? 'positive' : 'negative' }]);
}

function eraseTool(session: Session): PaneTool {
  const { app } = session;
  let stroke: { pane: Pane; points: Vec[] } | null = null;

  /* The chosen surface, whether or not it has a curve in the pane; else the one whose curve lies nearest to the stroke. */
  function target(pane: Pane, points: readonly Vec[]): string | null {
    const chosen = chosenSurface(app.store.state)?.json;
    if (chosen) return chosen.name;
    const away = (spline: Spline): number => Math.min(...points.map(([x, y]) => spline.nearest(x, y).distance));
    const nearest = pane.curves.map((curve) => ({ curve, off: away(curve.spline) })).sort((a, b) => a.off - b.off)[0];
    return nearest?.curve.surface ?? null;
  }

  function finish(pane: Pane, points: Vec[]): void {
    const length = points.reduce((sum, point, i) => (i ? sum + distance(...point, ...points[i - 1]) : 0), 0);
    if (length * pane.zoom < 12) return;
    const closed = isLoop(points, 14 * pane.pixel), surface = target(pane, points);
    if (!surface) return app.messages.say('There is no surface to erase from yet.');
    const knots = tidy(fitStroke(points, closed, { pixel: pane.pixel, half: false }), pane.pixel);
    app.store.set({ selectedSurface: surface });
    session.set({ cut: { pane: pane.name, surface, knots, closed, positive: null, line: new Spline(knots, closed).line } });
    app.store.set({ hint: `Click the side of the stroke that goes from ${surface}; Escape gives up.` });
  }

  return {
    name: 'erase', label: 'Erase', key: 'x', icon: 'cut', cursor: 'crosshair',
    hint: 'Draw a cutting stroke across the chosen surface, then click the side of it that goes.',
    down(event) {
      const { cut } = session.values;
      if (cut && cut.pane === event.pane.name) eraseSide(session, isPositive(cut.line, cut.closed, event.x, event.y));
      else {
        session.set({ cut: null });
        stroke = { pane: event.pane, points: [[event.x, event.y]] };
      }
      return true;
    },
    move({ x, y }) {
      stroke?.points.push([x, y]);
      session.tell();
    },
    hover(event) {
      const { cut } = session.values;
      if (!cut) return;
      const side = event?.pane.name === cut.pane ? isPositive(cut.line, cut.closed, event.x, event.y) : null;
      if (side !== cut.positive) session.set({ cut: { ...cut, positive: side } });
    },
    up({ pane }) {
      const done = stroke;
      stroke = null;
      if (done) finish(pane, done.points);
      session.tell();
    },
    cancel() {
      const had = stroke !== null || session.values.cut !== null;
      stroke = null;
      session.set({ cut: null });
      return had;
    },
    draw(brush, pane) {
      brush.setLineDash([7, 5]);
      if (stroke?.pane === pane) clearLine(brush, stroke.points.map(([x, y]) => pane.toScreen(x, y)), '#ffffff', 2);
      brush.setLineDash([]);
      const { cut } = session.values;
      if (cut?.pane === pane.name) drawCut(brush, pane, cut);
    },
  };
}

/* The stroke, going on straight beyond its ends, and the side that would go in red. */
function drawCut(brush: CanvasRenderingContext2D, pane: Pane, cut: CutStroke): void {
  const far = pane.width + pane.height, at = cut.line.map(([x, y]) => pane.toScreen(x, y));
  const beyond = (end: Vec, before: Vec): Vec => {
    const long = distance(...end, ...before) || 1;
    return [end[0] + (far * (end[0] - before[0])) / long, end[1] + (far * (end[1] - before[1])) / long];
  };
  const whole = cut.closed ? at : [beyond(at[0], at[1]), ...at, beyond(at[at.length - 1], at[at.length - 2])];
  if (cut.positive !== null) {
    const { curves } = pane, own = curves.filter((curve) => curve.surface === cut.surface);
    for (const { spline } of own) {
      let run: Vec[] = [];
      const flush = (): void => { if (run.length > 1) line(brush, run, '#ff4a3d', 5); run = []; };
      for (const [x, y] of spline.line) {
        if (isPositive(cut.line, cut.closed, x, y) === cut.positive) run.push(pane.toScreen(x, y));
        else flush();
      }
      flush();
    }
  }
  brush.setLineDash([7, 5]);
  clearLine(brush, whole, '#ffffff', 2);
  brush.setLineDash([]);
}

/* ---- colours ------------------------------------------------------------------------------------------------------------ */

function pickTool(): PaneTool {
  let at: PaneEvent | null = null, colour: string | null = null;
  return {
    name: 'pick', label: 'Pick a colour', key: 'i', icon: 'pick', cursor: 'crosshair',
    hint: 'Click the picture: its colour there is the one to paint with. Alt-click does so with any tool.',
    down(event) {
      pickColour(event);
      return true;
    },
    move(event) { pickColour(event); },
    hover(event) {
      at = event;
      colour = event && event.pane.session.pictures[event.pane.name].colourAt(event.x, event.y);
      event?.pane.session.tell();
    },
    draw(brush, pane) { if (at?.pane === pane && colour) dot(brush, [at.px + 18, at.py - 18], 11, colour, '#ffffff'); },
  };
}

/* ---- the picture -------------------------------------------------------------------------------------------------------- */

const knobPixels = 26;

interface Laying { how: 'move' | 'size' | 'turn'; from: Vec; before: Json; pane: Pane; moved: boolean }

function pictureTool(session: Session): PaneTool {
  let laying: Laying | null = null;

  const turnOf = (before: Json, x: number, y: number): number =>
    (Math.atan2(y - (before.y ?? 0), x - (before.x ?? 0)) * 180) / Math.PI;

  function laid({ before, from, how }: Laying, x: number, y: number, straight: boolean, digits: number): Json {
    const round = (value: number): number => Number(value.toFixed(digits)), cx = before.x ?? 0, cy = before.y ?? 0;
    if (how === 'move') return { ...before, x: round(cx + x - from[0]), y: round(cy + y - from[1]) };
    if (how === 'size') {
      const factor = distance(x, y, cx, cy) / (distance(...from, cx, cy) || 1);
      return { ...before, width: Math.max(1e-9, round((before.width ?? 2) * factor)) || (before.width ?? 2) };
    }
    let turn = (before.turn ?? 0) + turnOf(before, x, y) - turnOf(before, ...from);
    turn -= 360 * Math.round(turn / 360);
    return { ...before, turn: straight ? 15 * Math.round(turn / 15) : Number(turn.toFixed(1)) };
  }

  return {
    name: 'picture', label: 'Picture', key: 'r', icon: 'image', cursor: 'move',
    hint: 'Drag the picture, a corner of it to size it, the knob above it to turn it; with Shift in steps of 15°.',
    down({ pane, x, y, px, py, touch }) {
      const picture = session.pictures[pane.name], handles = picture.handles(knobPixels * pane.pixel), grip = touch ? 20 : 11;
      if (!handles || !picture.json) return false;
      const on = ([u, v]: Vec): boolean => distance(...pane.toScreen(u, v), px, py) < grip;
      const how = on(handles.knob) ? 'turn' : handles.corners.some(on) ? 'size' : isInside(handles.corners, x, y) ? 'move' : null;
      if (!how) return false;
      laying = { how, from: [x, y], before: picture.json, pane, moved: false };
      return true;
    },
    move({ pane, x, y, shift }) {
      if (!laying) return;
      const digits = Math.max(0, Math.ceil(-Math.log10(pane.pixel / 2)));
      laying.moved = true;
      session.heldPicture = { pane: laying.pane.name, value: laid(laying, x, y, shift, digits) };
      session.tell();
    },
    up() {
      const done = laying;
      laying = null;
      if (!done?.moved || !session.heldPicture) return;
      const words = { move: 'Move', size: 'Size', turn: 'Turn' }[done.how];
      void session.apply(`${words} the picture`, [{ op: 'set', path: `${sketchPath(session.app.store.state)}.${done.pane.name}`,
        value: session.heldPicture.value }]);
    },
    cancel() {
      const had = laying !== null;
      laying = null;
      session.release();
      return had;
    },
    draw(brush, pane) {
      const handles = session.pictures[pane.name].handles(knobPixels * pane.pixel);
      if (!handles) return;
      const at = handles.corners.map(([x, y]) => pane.toScreen(x, y));
      clearLine(brush, [...at, at[0]], '#ffffff', 1.2);
      clearLine(brush, [pane.toScreen(...handles.top), pane.toScreen(...handles.knob)], '#ffffff', 1.2);
      for (const corner of at) dot(brush, corner, 5, '#ffffff', '#202020');
      dot(brush, pane.toScreen(...handles.knob), 6, '#ffffff', '#202020');
    },
  };
}
