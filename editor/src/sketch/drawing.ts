// The tool that draws curves: with one drag, or click by click. What is drawn becomes a surface, or the chosen one's curve.

import type { Json } from '../protocol';
import { askText, type Objection } from '../ui/dialog';
import { chosenSurface, surfacesOf } from '../store';
import { axisColour, clearLine, dot, line } from './draw';
import { distance, pointsOf, Spline, type Knot, type Vec } from './curve';
import { addSurface, drawHorizontal, foldAt, foldsOf, freeSurfaceName, middleOf, nameFor, nextColour, redrawVertical } from './drawn';
import { fitStroke, isLoop, tidy, toHalfPlane } from './fit';
import type { Pane } from './pane';
import type { Session } from './session';
import type { PaneTool } from './tool';

/** Pixels within which ends snap to the axis, and to one another. */
export const snapPixels = 8;
const joinPixels = 14;

interface Drawing { pane: Pane; stroke: Vec[]; knots: Knot[]; from: Vec; dragging: boolean; hover: Vec | null }

export function drawTool(session: Session): PaneTool {
  let under: Drawing | null = null;

  const screen = (pane: Pane, [x, y]: Vec): Vec => pane.toScreen(x, y);
  const near = (pane: Pane, a: Vec, b: Vec): boolean => distance(...screen(pane, a), ...screen(pane, b)) < joinPixels;

  function finish(closed: boolean): void {
    const done = under;
    under = null;
    session.tell();
    if (done && done.knots.length >= (closed ? 3 : 2)) take(session, done.pane, done.knots, closed);
  }

  return {
    name: 'draw', label: 'Draw', key: 'd', icon: 'edit', cursor: 'crosshair',
    hint: 'Draw a curve with one drag, or click its points and press Enter. Ends near the axis snap to it; ends that meet close a loop.',
    down({ pane, x, y }) {
      if (under && under.pane !== pane) under = null;
      if (under) {                    // the curve goes on click by click
        if (under.knots.length > 2 && near(pane, [x, y], [under.knots[0].x, under.knots[0].y])) {
          finish(true);
          return true;
        }
        under.knots.push({ x, y, corner: false });
      } else under = { pane, stroke: [[x, y]], knots: [], from: [x, y], dragging: false, hover: null };
      session.tell();
      return true;
    },
    move({ pane, x, y }) {
      if (!under) return;
      if (under.knots.length > 0) {
        const last = under.knots[under.knots.length - 1];
        [last.x, last.y] = [x, y];
      } else {
        under.dragging ||= distance(...screen(pane, under.from), ...screen(pane, [x, y])) > 5;
        under.stroke.push([x, y]);
      }
      session.tell();
    },
    up({ pane }) {
      if (!under || under.knots.length > 0) return;
      if (!under.dragging) {
        under.knots = [{ x: under.from[0], y: under.from[1], corner: false }];
        return session.tell();
      }
      const closed = isLoop(under.stroke, joinPixels * pane.pixel);
      under.knots = fitStroke(under.stroke, closed, { pixel: pane.pixel, half: pane.name === 'vertical' });
      finish(closed);
    },
    hover(event) {
      if (!under || (event && event.pane !== under.pane)) return;
      under.hover = event && [event.x, event.y];
      session.tell();
    },
    double() {                        // the second click of it added a point where the first had
      if (!under || under.knots.length < 3) return;
      under.knots.pop();
      finish(false);
    },
    keys(event) {
      if (!under || (event.key !== 'Enter' && event.key !== 'Backspace')) return false;
      if (event.key === 'Enter') finish(false);
      else if (under.knots.length > 1) under.knots.pop();
      else under = null;
      session.tell();
      return true;
    },
    cancel() {
      const had = under !== null;
      under = null;
      session.tell();
      return had;
    },
    draw(brush, pane) {
      if (under?.pane !== pane) return;
      const { stroke, knots, hover } = under;
      if (knots.length === 0) return clearLine(brush, stroke.map((point) => screen(pane, point)), '#ffffff', 2);
      const all = hover ? [...knots, { x: hover[0], y: hover[1], corner: false }] : knots;
      if (all.length > 1) {
        clearLine(brush, new Spline(all, false).line.map((point) => screen(pane, point)), '#ffffff', 2);
      }
      for (const { x, y } of knots) dot(brush, pane.toScreen(x, y), 3.5, '#ffffff', '#202020');
      if (hover && knots.length > 2 && near(pane, hover, [knots[0].x, knots[0].y])) {
        dot(brush, pane.toScreen(knots[0].x, knots[0].y), 7, axisColour, '#ffffff');
      }
      if (hover && pane.name === 'vertical' && Math.abs(hover[0]) * pane.zoom < snapPixels) {
        const [px, py] = pane.toScreen(0, hover[1]);
        line(brush, [[px - 7, py], [px + 7, py]], '#ffffff', 2);
      }
    },
  };
}

/* ---- what is drawn becomes part of the document ----------------------------------------------------------------------- */

function take(session: Session, pane: Pane, drawn: Knot[], closed: boolean): void {
  const { app } = session, { state } = app.store, pixel = pane.pixel;
  if (pane.name === 'vertical') {
    const knots = tidy(toHalfPlane(drawn, closed, snapPixels * pixel, pixel), pixel);
    const surface = chosenSurface(state)?.json;
    if (session.values.redraw && surface?.kind === 'grains') return strew(session, pane, drawn);
    if (session.values.redraw && surface?.vertical) redraw(session, surface, knots, closed, snapPixels * pixel);
    else newSurface(session, knots, closed);
    return;
  }
  const surface = chosenSurface(state)?.json;
  if (!closed) return app.messages.say('Across the axis curves are loops; end the stroke where it began.', 'warning');
  if (!surface?.vertical) {
    return app.messages.say('Draw the surface along the axis first, or choose one; then draw how it runs across.', 'warning');
  }
  const at = surfacesOf(state).indexOf(surface), knots = tidy(drawn, pixel);
  const fold = surface.kind === 'chambers' ? ` in fold ${foldAt(foldsOf(state), ...middleOf(knots)) + 1}` : '';
  void session.apply(`Draw ${surface.name} across${fold}`, drawHorizontal(state, surface, at, knots));
}

function redraw(session: Session, surface: Json, knots: Knot[], closed: boolean, snap: number): void {
  const { app } = session, { state } = app.store;
  if (surface.kind === 'chambers' && !closed) {
    return app.messages.say('Chambers are loops beside the axis; end the stroke where it began.', 'warning');
  }
  const at = surfacesOf(state).indexOf(surface);
  void session.apply(`Draw ${surface.name} anew`, redrawVertical(state, surface, at, knots, closed, snap));
}

/** How wide the brush is that says where grains are strewn, pixels. */
export const strewPixels = 14;

/* The stroke, all round the axis, is where the chosen grains are strewn; what was drawn before stays so, too. */
function strew(session: Session, pane: Pane, knots: Knot[]): void {
  const { place, json } = chosenSurface(session.app.store.state)!, round = (value: number): number => Number(value.toPrecision(4));
  const brush = { points: tidy(knots, pane.pixel).map(({ x, y }) => [Math.max(0, x), 0, y]), radius: round(strewPixels * pane.pixel), repeat: 'around' };
  void session.apply(`Strew ${json.name} there`, [{ op: 'set', path: `${place}.region[${(json.region ?? []).length}]`, value: brush }]);
}

/* Asks for a name; the curve shows meanwhile. */
function newSurface(session: Session, knots: Knot[], closed: boolean): void {
  const { app } = session, { store } = app, kind = closed && foldsOf(store.state).count > 0 ? 'chambers' : 'around';
  const words = kind === 'chambers' ? 'New chambers, one in each fold' : closed ? 'New ring round the axis' : 'New surface round the axis';
  askText({ title: words, label: 'Name', value: nameFor(store.state, kind), act: 'Add', none: 'Type a name.',
    run: async (name): Promise<Objection | null> => {
      if (surfacesOf(store.state).some((each) => each.name === name)) {
        return { why: `There is a surface “${name}” already; ${freeSurfaceName(store.state, name)} is free.` };
      }
      const surface = { name, kind, vertical: pointsOf(knots), ...(closed && kind === 'around' ? { closed } : {}),
        colours: { front: nextColour(store.state) } };
      if (await session.apply(`Draw ${name}`, addSurface(store.state, surface))) store.set({ selectedSurface: name });
      return null;
    } });
}

