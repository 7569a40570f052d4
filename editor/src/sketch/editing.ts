// Tools that change curves that are there: points dragged, added, taken away and made corners; bending; smoothing.

import { bend, smoothed } from './bend';
import { distance, type Knot, type Vec } from './curve';
import { curveOperation, sketchPath, type Curve } from './drawn';
import { clearLine, foldHandle, line, themeColour } from './draw';
import { snapPixels } from './drawing';
import { tidy } from './fit';
import type { Pane } from './pane';
import type { Session } from './session';
import type { PaneEvent, PaneTool } from './tool';
import { chosenSurface, surfaceKey } from '../store';

/* ---- what is under the pointer --------------------------------------------------------------------------------------- */

interface Under { curve: Curve; knot: number; away: number }

const grip = (event: PaneEvent): number => (event.touch ? 18 : 9);

/* The knot under the pointer, of the chosen surface alone; else the curve, the chosen surface's first. */
function find(session: Session, event: PaneEvent): Under | null {
  const { pane, x, y } = event, { selectedSurface } = session.app.store.state, reach = grip(event);
  let best: Under | null = null;
  for (const curve of pane.curves) {
    if (curve.surface !== selectedSurface) continue;
    curve.knots.forEach((knot, i) => {
      const away = distance(knot.x, knot.y, x, y) * pane.zoom;
      if (away < reach && (!best || away < best.away)) best = { curve, knot: i, away };
    });
  }
  if (best) return best;
  for (const curve of pane.curves) {
    const chosen = curve.surface === selectedSurface, away = curve.spline.nearest(x, y).distance * pane.zoom - (chosen ? 3 : 0);
    if (away < reach && (!best || away < (best as Under).away)) best = { curve, knot: -1, away };
  }
  return best;
}

/* Inner knots of vertical curves keep off the axis; ends slide onto it. */
function held(pane: Pane, curve: Curve, knots: Knot[]): Knot[] {
  if (curve.pane !== 'vertical') return knots;
  return knots.map((knot, i) => {
    const end = !curve.closed && (i === 0 || i === knots.length - 1);
    if (end) return knot.x * pane.zoom < snapPixels ? { ...knot, x: 0 } : knot;
    return { ...knot, x: Math.max(knot.x, pane.pixel) };
  });
}

function write(session: Session, pane: Pane, name: string, curve: Curve, knots: Knot[]): void {
  const rounded = tidy(knots, pane.pixel);
  session.hold(curve.key, knots);
  void session.apply(name, [curveOperation(session.app.store.state, curve, rounded, snapPixels * pane.pixel)]);
}

/* The knots with one more where the curve is nearest to a point. */
function withKnot(curve: Curve, x: number, y: number): { knots: Knot[]; index: number } {
  const place = curve.spline.nearest(x, y), knots = curve.knots.slice();
  knots.splice(place.piece + 1, 0, { x: place.x, y: place.y, corner: false });
  return { knots, index: place.piece + 1 };
}

/* ---- points ----------------------------------------------------------------------------------------------------------- */

type Drag = { kind: 'knot'; curve: Curve; index: number; from: Vec; moved: boolean }
  | { kind: 'bend'; pull: Pull } | { kind: 'folds'; moved: boolean };

export function editTool(session: Session): PaneTool {
  const { app } = session;
  let drag: Drag | null = null;

  return {
    name: 'edit', label: 'Points', key: 'e', icon: 'select', cursor: 'default',
    hint: 'Drag a point; drag the curve to bend it. Double-click the curve for another point, a point for a corner; Delete takes it away.',
    down(event) {
      const { pane, px, py } = event, handle = foldHandle(pane);
      if (handle && distance(...handle, px, py) < grip(event) + 3) {
        drag = { kind: 'folds', moved: false };
        return true;
      }
      const under = find(session, event);
      if (!under) {
        session.set({ knot: null });
        return false;
      }
      const chosen = under.curve.surface === app.store.state.selectedSurface;
      app.store.set({ selectedSurface: under.curve.surface });
      session.set({ knot: under.knot >= 0 ? { curve: under.curve.key, index: under.knot } : null });
      if (under.knot >= 0) {
        const { x, y } = under.curve.knots[under.knot];
        drag = { kind: 'knot', curve: under.curve, index: under.knot, from: [x - event.x, y - event.y], moved: false };
      } else if (chosen) drag = { kind: 'bend', pull: new Pull(session, under.curve, event) };
      return true;
    },
    move({ pane, x, y }) {
      if (drag?.kind === 'folds') {
        const step = (Math.atan2(y, x) * 180) / Math.PI;
        drag.moved = true;
        session.heldAngle = Math.round(10 * step) / 10;
        session.tell();
      } else if (drag?.kind === 'bend') drag.pull.to(x, y);
      else if (drag) {
        const { curve, index, from } = drag;
        drag.moved = true;
        const knots = curve.knots.map((knot, i) => (i === index ? { ...knot, x: x + from[0], y: y + from[1] } : knot));
        session.hold(curve.key, held(pane, curve, knots));
      }
    },
    up({ pane }) {
      const done = drag;
      drag = null;
      if (done?.kind === 'bend') done.pull.finish();
      else if (done?.kind === 'folds' && done.moved && session.heldAngle !== null) turnFolds(session, session.heldAngle);
      else if (done?.kind === 'knot' && done.moved) {
        write(session, pane, 'Move point', done.curve, session.held.get(done.curve.key) ?? done.curve.knots);
      }
      session.tell();
    },
    wheel(_, delta) {
      if (drag?.kind !== 'bend') return false;
      drag.pull.widen(delta);
      return true;
    },
    double(event) {
      const under = find(session, event);
      if (!under || under.curve.surface !== app.store.state.selectedSurface) return;
      if (under.knot >= 0) return toggleCorner(session, event.pane, under.curve, under.knot);
      const { knots, index } = withKnot(under.curve, event.x, event.y);
      session.set({ knot: { curve: under.curve.key, index } });
      write(session, event.pane, 'Add point', under.curve, knots);
    },
    keys(event, pane) {
      const { knot } = session.values, curve = knot && session.curve(knot.curve);
      if (!knot || !curve || curve.pane !== pane.name) return false;
      if (event.key === 'Delete' || event.key === 'Backspace') removeKnot(session, pane, curve, knot.index);
      else if (event.key === 'c') toggleCorner(session, pane, curve, knot.index);
      else if (event.key.startsWith('Arrow')) {
        const step = (event.shiftKey ? 10 : 1) * pane.pixel;
        const [dx, dy] = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key]!;
        write(session, pane, 'Move point', curve, held(pane, curve, curve.knots.map((each, i) =>
          (i === knot.index ? { ...each, x: each.x + dx, y: each.y + dy } : each))));
      } else return false;
      return true;
    },
    cancel() {
      const had = drag !== null || session.values.knot !== null;
      if (drag?.kind === 'bend') drag.pull.cancel();
      drag = null;
      session.values.knot = null;
      session.release();
      return had;
    },
    draw(brush, pane) { if (drag?.kind === 'bend') drag.pull.draw(brush, pane); },
  };
}

export function removeKnot(session: Session, pane: Pane, curve: Curve, index: number): void {
  const least = curve.closed ? 3 : 2;
  if (curve.knots.length <= least) return session.app.messages.say(`A ${curve.closed ? 'loop' : 'curve'} needs ${least} points.`);
  session.values.knot = null;
  write(session, pane, 'Remove point', curve, curve.knots.filter((_, i) => i !== index));
}

export function toggleCorner(session: Session, pane: Pane, curve: Curve, index: number): void {
  const corner = !curve.knots[index].corner;
  write(session, pane, corner ? 'Make a corner' : 'Round a corner', curve,
    curve.knots.map((knot, i) => (i === index ? { ...knot, corner } : knot)));
}

function turnFolds(session: Session, angle: number): void {
  const turn = Number(((angle + 360) % 360).toFixed(1));
  void session.apply('Turn the folds', [{ op: 'set', path: `${sketchPath(session.app.store.state)}.fold_angle`, value: turn }]);
}

/* ---- bending ----------------------------------------------------------------------------------------------------------- */

/* A curve pulled at a place on it. A place between points first gets a point of its own. */
class Pull {
  private readonly knots: Knot[];
  private readonly index: number;
  private readonly added: boolean;
  private readonly from: Vec;
  private readonly along: number;
  private target: Vec | null = null;

  constructor(private readonly session: Session, private readonly curve: Curve, private readonly event: PaneEvent) {
    const { spline, knots } = curve, place = spline.nearest(event.x, event.y), ends = [place.piece, (place.piece + 1) % knots.length];
    const near = ends.find((i) => distance(knots[i].x, knots[i].y, place.x, place.y) * event.pane.zoom < 7);
    this.added = near === undefined;
    if (near === undefined) ({ knots: this.knots, index: this.index } = withKnot(curve, event.x, event.y));
    else [this.knots, this.index] = [knots, near];
    this.from = [this.knots[this.index].x, this.knots[this.index].y];
    this.along = place.length;
    if (!(session.values.reach > 0)) session.values.reach = Number((spline.length / 4).toPrecision(2));
  }

  to(x: number, y: number): void {
    this.target = [this.from[0] + x - this.event.x, this.from[1] + y - this.event.y];
    const bent = bend(this.knots, this.curve.closed, this.index, ...this.target, this.reach);
    this.session.hold(this.curve.key, held(this.event.pane, this.curve, bent));
  }

  /* No farther than to where the curve meets the axis: there it stays. */
  private get reach(): number {
    const { knots, index, curve } = this, onAxis = (i: number): boolean => curve.pane === 'vertical' && !curve.closed && knots[i].x === 0;
    const along = (from: number, to: number): number => knots.slice(from + 1, to + 1)
      .reduce((sum, knot, i) => sum + distance(knot.x, knot.y, knots[from + i].x, knots[from + i].y), 0);
    const ends = [onAxis(0) && index > 0 ? along(0, index) : Infinity,
      onAxis(knots.length - 1) && index < knots.length - 1 ? along(index, knots.length - 1) : Infinity];
    return Math.min(this.session.values.reach, 0.999 * Math.min(...ends));
  }

  widen(delta: number): void {
    const { reach } = this.session.values, next = reach * Math.exp(-0.0015 * Math.max(-200, Math.min(200, delta)));
    this.session.set({ reach: Math.min(this.curve.spline.length, Math.max(4 * this.event.pane.pixel, next)) });
    if (this.target) this.to(this.event.x + this.target[0] - this.from[0], this.event.y + this.target[1] - this.from[1]);
  }

  finish(): void {
    const { session, curve, event } = this, { state } = session.app.store, round = (value: number): number => Number(value.toPrecision(7));
    if (!this.target || distance(...this.target, ...this.from) * event.pane.zoom < 1) return this.cancel();
    const shaped = this.added || curve.implied
      ? [curveOperation(state, curve, this.knots.map((knot) => ({ ...knot, x: round(knot.x), y: round(knot.y) })), 0)] : [];
    void session.apply(`Bend ${curve.surface}`, [...shaped, { op: 'surface.deform', ...surfaceKey(state), surface: curve.surface,
      pane: curve.pane, ...(curve.loop > 0 ? { index: curve.loop } : {}), drag: [this.from.map(round), this.target.map(round)],
      reach: round(this.reach) }]);
  }

  cancel(): void { this.session.release(); }

  draw(brush: CanvasRenderingContext2D, pane: Pane): void {
    if (pane !== this.event.pane) return;
    const spline = this.session.curve(this.curve.key)?.spline ?? this.curve.spline;
    const stretch = spline.stretch(Math.min(this.along, spline.length), this.reach);
    brush.globalAlpha = 0.5;
    line(brush, stretch.map(([x, y]) => pane.toScreen(x, y)), themeColour('accent'), 10);
    brush.globalAlpha = 1;
  }
}

export function bendTool(session: Session): PaneTool {
  const { app } = session;
  let pull: Pull | null = null;
  return {
    name: 'bend', label: 'Bend', key: 'b', icon: 'bend', cursor: 'grab',
    hint: 'Drag a curve: it bends as rigidly as it can, as far to both sides as the wheel says meanwhile.',
    down(event) {
      const under = find(session, event);
      if (!under) return false;
      app.store.set({ selectedSurface: under.curve.surface });
      pull = new Pull(session, under.curve, event);
      session.tell();
      return true;
    },
    move({ x, y }) { pull?.to(x, y); },
    up() {
      pull?.finish();
      pull = null;
    },
    wheel(_, delta) {
      pull?.widen(delta);
      return pull !== null;
    },
    cancel() {
      const had = pull !== null;
      pull = null;
      session.release();
      return had;
    },
    draw(brush, pane) { pull?.draw(brush, pane); },
  };
}

/* ---- smoothing --------------------------------------------------------------------------------------------------------- */

/** Smooths all curves of the chosen surface in a pane, or in both. */
export function smoothAll(session: Session): void {
  const { state } = session.app.store, surface = chosenSurface(state)?.json;
  const curves = session.curves.filter((curve) => curve.surface === surface?.name && !curve.implied);
  if (!surface || curves.length === 0) return session.app.messages.say('Choose a surface with curves first.');
  void session.apply(`Smooth ${surface.name}`, curves.map((curve) => ({ op: 'surface.smooth', ...surfaceKey(state),
    surface: curve.surface, pane: curve.pane, ...(curve.loop > 0 ? { index: curve.loop } : {}), amount: session.values.smoothing })));
}

export function smoothTool(session: Session): PaneTool {
  const { app } = session;
  let brushed: { curve: Curve; knots: Knot[] } | null = null, at: PaneEvent | null = null;

  /* Each time the brush passes a knot it is smoothed a little more. */
  function brush({ pane, x, y }: PaneEvent): void {
    if (!brushed) return;
    const radius = session.values.brush * pane.pixel;
    const share = (knot: Knot): number => Math.max(0, 1 - (distance(knot.x, knot.y, x, y) / radius) ** 2);
    brushed.knots = smoothed(brushed.knots, brushed.curve.closed, 0.03 * session.values.smoothing + 0.01, share);
    session.hold(brushed.curve.key, held(pane, brushed.curve, brushed.knots));
  }

  return {
    name: 'smooth', label: 'Smooth', key: 's', icon: 'smooth', cursor: 'none',
    hint: 'Brush over a curve to smooth it there; the button smooths all curves of the surface.',
    down(event) {
      const { pane, x, y } = event, { selectedSurface } = app.store.state;
      const near = pane.curves.map((curve) => ({ curve, away: curve.spline.nearest(x, y).distance * pane.zoom }))
        .filter(({ away }) => away < session.values.brush)
        .sort((a, b) => Number(b.curve.surface === selectedSurface) - Number(a.curve.surface === selectedSurface) || a.away - b.away)[0];
      if (!near) return false;
      app.store.set({ selectedSurface: near.curve.surface });
      brushed = { curve: near.curve, knots: near.curve.knots };
      at = event;
      brush(event);
      return true;
    },
    move(event) {
      at = event;
      brush(event);
      session.tell();
    },
    hover(event) {
      at = event;
      session.tell();
    },
    up({ pane }) {
      const done = brushed;
      brushed = null;
      if (done) write(session, pane, `Smooth ${done.curve.surface}`, done.curve, session.held.get(done.curve.key) ?? done.knots);
    },
    cancel() {
      const had = brushed !== null;
      brushed = null;
      session.release();
      return had;
    },
    draw(canvas, pane) {
      if (at?.pane !== pane) return;
      const { brush: radius } = session.values, { px, py } = at;
      const ring = Array.from({ length: 41 }, (_, i): Vec =>
        [px + radius * Math.cos((i / 20) * Math.PI), py + radius * Math.sin((i / 20) * Math.PI)]);
      clearLine(canvas, ring, '#ffffff', 1.2);
    },
  };
}
