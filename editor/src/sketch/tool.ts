// What a tool of the panes is: it gets what the pointer does over a pane, and turns it into operations.

import type { IconName } from '../ui/icons';
import type { Pane } from './pane';
import type { PaneToolName } from './session';

export interface PaneEvent {
  pane: Pane;
  x: number;                        // model units
  y: number;
  px: number;                       // CSS pixels in the pane
  py: number;
  shift: boolean;
  touch: boolean;                   // a finger aims less well than a mouse
}

export interface PaneTool {
  readonly name: PaneToolName;
  readonly label: string;
  readonly key: string;             // the keyboard's letter, in the panes
  readonly icon: IconName;
  readonly hint: string;
  /** True when the tool takes the drag. */
  down(event: PaneEvent): boolean;
  move?(event: PaneEvent): void;    // with the button down
  hover?(event: PaneEvent | null): void; // without; null: the pointer has left
  up?(event: PaneEvent): void;
  /** True when the tool used the wheel; else the pane zooms. */
  wheel?(event: PaneEvent, delta: number): boolean;
  double?(event: PaneEvent): void;
  /** True when the key was the tool's. */
  keys?(event: KeyboardEvent, pane: Pane): boolean;
  /** Escape, another tool, or the drag was taken away; false when there was nothing to give up. */
  cancel?(): boolean;
  /** What it shows over the curves of a pane; the brush draws in CSS pixels. */
  draw?(brush: CanvasRenderingContext2D, pane: Pane): void;
  cursor?: string;
}
