// What is going on in the panes: the tool, the curve and the point that are chosen, what a hand holds at the moment. The
// store knows the rest.

import type { App } from '../app';
import type { Json } from '../protocol';
import { recall, remember } from '../ui/dom';
import type { Knot, Vec } from './curve';
import { curvesOf, type Curve, type PaneName } from './drawn';
import { ReferencePicture } from './picture';

export type PaneToolName = 'edit' | 'draw' | 'bend' | 'smooth' | 'erase' | 'pick' | 'picture';

/** A knot that is chosen. */
export interface ChosenKnot { curve: string; index: number }

/** A cutting stroke that waits for the side that goes. */
export interface CutStroke { pane: PaneName; surface: string; line: Vec[]; knots: Knot[]; closed: boolean; positive: boolean | null }

interface Values {
  tool: PaneToolName;
  redraw: boolean;                  // does drawing replace the chosen surface's curve along the axis?
  knot: ChosenKnot | null;
  reach: number;                    // of bending, model units; 0: not chosen yet
  brush: number;                    // radius of smoothing, pixels
  smoothing: number;                // 0..1
  cut: CutStroke | null;
}

export class Session {
  readonly values: Values = { tool: 'draw', redraw: false, knot: null, reach: 0, brush: 28, smoothing: 0.5, cut: null };
  /** Knots under a hand, by keys of curves; they show instead of the document's. */
  readonly held = new Map<string, Knot[]>();
  /** Values of the reference picture and of the folds' angle under a hand. */
  heldPicture: { pane: PaneName; value: Json } | null = null;
  heldAngle: number | null = null;
  readonly pictures: { [pane in PaneName]: ReferencePicture };
  private readonly listeners: (() => void)[] = [];
  private known: Curve[] | null = null;

  constructor(readonly app: App) {
    this.pictures = { vertical: new ReferencePicture(this, 'vertical'), horizontal: new ReferencePicture(this, 'horizontal') };
    app.store.on(['document', 'body'], () => this.changed());
    app.store.on(['selectedSurface', 'shownSurfaces', 'theme', 'sketching'], () => this.tell());
  }

  /** Calls back after anything that panes show has changed, once for all changes of a moment. */
  on(call: () => void): void { this.listeners.push(call); }

  set(values: Partial<Values>): void {
    Object.assign(this.values, values);
    this.tell();
  }

  /** The curves of the body, those under a hand as the hand holds them. */
  get curves(): Curve[] { return (this.known ??= curvesOf(this.app.store.state, this.held)); }

  curve(key: string): Curve | undefined { return this.curves.find((each) => each.key === key); }

  /** Shows knots instead of those of the document; null: the document's again. */
  hold(key: string, knots: Knot[] | null): void {
    if (knots) this.held.set(key, knots);
    else this.held.delete(key);
    this.changed();
  }

  /** Does operations on the document; what was held shows until they are done, or refused. */
  async apply(name: string, operations: Json[]): Promise<boolean> {
    const done = await this.app.actions.apply(name, operations);
    this.release();
    return done;
  }

  release(): void {
    this.held.clear();
    this.heldPicture = null;
    this.heldAngle = null;
    this.changed();
  }

  /** How strongly a pane's picture shows, 0..1; kept for the next visit. */
  opacity(pane: PaneName, value?: number): number {
    if (value !== undefined) {
      remember(`sketch.opacity.${pane}`, String(value));
      this.tell();
    }
    const kept = recall(`sketch.opacity.${pane}`);
    return kept === null ? 0.6 : Number(kept);
  }

  /** What is shown may be another now. */
  changed(): void {
    this.known = null;
    const { knot } = this.values, curve = knot && this.curve(knot.curve);
    if (knot && (!curve || knot.index >= curve.knots.length)) this.values.knot = null;
    this.tell();
  }

  private due = false;
  tell(): void {
    if (this.due) return;
    this.due = true;
    queueMicrotask(() => {
      this.due = false;
      for (const call of this.listeners) call();
    });
  }
}
