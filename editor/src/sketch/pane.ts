// A pane of the sketch: what part of the plane it shows, and what the pointer does over it.

import type { App } from '../app';
import { h } from '../ui/dom';
import type { Vec } from './curve';
import type { Curve, PaneName } from './drawn';
import { drawPane } from './draw';
import type { Session } from './session';
import type { PaneEvent, PaneTool } from './tool';

const words: { [pane in PaneName]: string } = {
  vertical: 'The half-plane right of the axis: radius and height', horizontal: 'A plane across the axis: x and y',
};

export class Pane {
  readonly canvas: HTMLCanvasElement;
  /** What lies in the middle, and CSS pixels for each model unit. */
  middle: Vec = [0, 0];
  zoom = 100;
  width = 1;
  height = 1;
  /** Called with events that a tool may use; set by the workspace. */
  tool: () => PaneTool = () => { throw new Error('no tool'); };

  private readonly fingers = new Map<number, Vec>();
  private taken = -1;               // the pointer whose drag the tool has
  private panning = -1;
  private framed = false;
  private due = false;

  constructor(readonly app: App, readonly session: Session, readonly name: PaneName) {
    this.canvas = h('canvas', { class: 'pane-canvas', tabindex: 0, 'aria-label': words[name] });
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    session.on(() => this.invalidate());
  }

  /* ---- where things are ---- */

  /** Model units for each CSS pixel. */
  get pixel(): number { return 1 / this.zoom; }

  toScreen(x: number, y: number): Vec {
    return [this.width / 2 + (x - this.middle[0]) * this.zoom, this.height / 2 - (y - this.middle[1]) * this.zoom];
  }

  toModel(px: number, py: number): Vec {
    return [this.middle[0] + (px - this.width / 2) / this.zoom, this.middle[1] - (py - this.height / 2) / this.zoom];
  }

  get curves(): Curve[] {
    const { shownSurfaces, selectedSurface } = this.app.store.state;
    return this.session.curves.filter((curve) => curve.pane === this.name
      && (shownSurfaces[curve.surface] !== false || curve.surface === selectedSurface));
  }

  /** Shows everything that is drawn, and the picture. */
  frame(): void {
    const points: Vec[] = this.curves.flatMap((curve) => curve.spline.line);
    points.push(...this.session.pictures[this.name].handles(0)?.corners ?? []);
    const ends = (k: 0 | 1): Vec => {
      const all = points.map((point) => point[k]);
      return all.length > 0 ? [Math.min(...all), Math.max(...all)] : [-1, 1];
    };
    const [y0, y1] = ends(1);
    let [x0, x1] = ends(0);
    if (this.name === 'vertical') x0 = Math.min(x0, -0.25 * x1); // a little of the mirror image
    else [x0, x1] = [Math.min(x0, -x1), Math.max(x1, -x0)];
    this.middle = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.zoom = Math.min((0.8 * this.width) / (x1 - x0 || 1), (0.8 * this.height) / (y1 - y0 || 1));
    this.framed = true;
    this.invalidate();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas, ratio = Math.min(2, window.devicePixelRatio || 1);
    if (clientWidth === 0 || clientHeight === 0) return;
    this.width = clientWidth;
    this.height = clientHeight;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    if (!this.framed && this.app.store.state.connection === 'open') this.frame();
    this.draw(ratio);
  }

  /** Draws it anew, with the next picture of the page. */
  invalidate(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw(this.canvas.width / this.width);
    });
  }

  private draw(ratio: number): void {
    if (!this.canvas.isConnected || this.canvas.clientWidth === 0) return;
    const brush = this.canvas.getContext('2d')!;
    brush.setTransform(ratio, 0, 0, ratio, 0, 0);
    brush.clearRect(0, 0, this.width, this.height);
    drawPane(brush, this);
    this.tool().draw?.(brush, this);
  }

  /* ---- the pointer ---- */

  private eventOf(event: PointerEvent | MouseEvent): PaneEvent {
    const box = this.canvas.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
    const [x, y] = this.toModel(px, py);
    return { pane: this, x, y, px, py, shift: event.shiftKey, touch: 'pointerType' in event && event.pointerType === 'touch' };
  }

  private listen(): void {
    const { canvas } = this;
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', (event) => this.lost(event));
    canvas.addEventListener('pointerleave', () => { if (this.taken < 0) this.tool().hover?.(null); });
    canvas.addEventListener('dblclick', (event) => { if (!event.altKey) this.tool().double?.(this.eventOf(event)); });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
  }

  private down(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    const at = this.eventOf(event);
    if (this.fingers.size > 1) {      // two fingers move the pane
      if (this.taken >= 0) this.tool().cancel?.();
      this.taken = -1;
    } else if (event.button === 0 && event.altKey) pickColour(at);
    else if (event.button === 0 && this.tool().down(at)) this.taken = event.pointerId;
    else this.panning = event.pointerId;
  }

  private move(event: PointerEvent): void {
    const before = this.fingers.get(event.pointerId);
    if (this.taken === event.pointerId) {
      // A quick hand goes on between two pictures; all of its way is drawn.
      const between = event.getCoalescedEvents?.() ?? [];
      for (const each of between.length > 0 ? between : [event]) this.tool().move?.(this.eventOf(each));
    } else if (before && (this.panning === event.pointerId || this.fingers.size > 1)) {
      this.drag(event, before);
    } else if (this.fingers.size === 0) this.tool().hover?.(this.eventOf(event));
    if (before) this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  /* One finger or button moves the pane, two change its size about the middle between them. */
  private drag(event: PointerEvent, before: Vec): void {
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1], share = other ? 0.5 : 1;
    if (other) {
      const was = Math.hypot(before[0] - other[0], before[1] - other[1]), box = this.canvas.getBoundingClientRect();
      const now = Math.hypot(event.clientX - other[0], event.clientY - other[1]);
      if (was > 10 && now > 10) {
        this.zoomBy(now / was, (before[0] + other[0]) / 2 - box.left, (before[1] + other[1]) / 2 - box.top);
      }
    }
    this.middle = [this.middle[0] - (share * dx) / this.zoom, this.middle[1] + (share * dy) / this.zoom];
    this.invalidate();
  }

  private up(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    if (this.panning === event.pointerId) this.panning = -1;
    if (this.taken !== event.pointerId) return;
    this.taken = -1;
    this.tool().up?.(this.eventOf(event));
  }

  private lost(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    if (this.panning === event.pointerId) this.panning = -1;
    if (this.taken !== event.pointerId) return;
    this.taken = -1;
    this.tool().cancel?.();
  }

  /** Ends a drag that a tool has without doing it; false when none has. */
  giveUp(): boolean {
    const had = this.taken >= 0;
    this.taken = -1;
    return had;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const at = this.eventOf(event), step = event.deltaY * (event.deltaMode === 1 ? 30 : 1);
    if (!event.ctrlKey && this.tool().wheel?.(at, step)) return;
    this.zoomBy(Math.exp(-0.0015 * Math.max(-200, Math.min(200, step))), at.px, at.py);
  }

  private zoomBy(factor: number, px: number, py: number): void {
    const [x, y] = this.toModel(px, py), zoom = this.zoom * factor;
    if (!(zoom > 1e-6 && zoom < 1e9)) return;
    this.zoom = zoom;
    const [u, v] = this.toModel(px, py);
    this.middle = [this.middle[0] + x - u, this.middle[1] + y - v];
    this.invalidate();
  }
}

/** Takes the colour of the pane's picture under the pointer as the one to paint with. */
export function pickColour({ pane, x, y }: PaneEvent): boolean {
  const { app, session } = pane, picture = session.pictures[pane.name], colour = picture.colourAt(x, y);
  if (colour) app.store.set({ paintColour: colour });
  else app.messages.say(picture.json ? 'There is no colour of the picture under the pointer.'
    : 'There is no picture in this pane to take colours from; load one first.');
  return colour !== null;
}
