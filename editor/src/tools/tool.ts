// What a tool is: it gets what the pointer does over the view, and turns it into operations.

import type { Vector3 } from 'three';
import type { ToolName } from '../store';

/** Where the pointer meets what is seen. */
export interface Hit {
  part: number;         // of the view; -1: a layer of depth
  body: number;
  triangle: number;     // of the view's triangles, or the layer's
  point: Vector3;       // material coordinates: what operations take
  world: Vector3;       // where it is seen: with the part's offset
  normal: Vector3;      // of the triangle, towards the eye's side
  kind: 'skin' | 'section' | 'layer';
  face: number;         // triangle of the cleaned mesh, -1 for none
  distance: number;
}

export interface ToolEvent {
  x: number;            // CSS pixels in the view
  y: number;
  pointer: PointerEvent | WheelEvent | MouseEvent;
  /** What is under the pointer; computed when asked for. */
  hit(): Hit | null;
  /** The ray from the eye through the pointer, world space. */
  ray(): { origin: Vector3; direction: Vector3 };
}

export interface Tool {
  readonly name: ToolName;
  readonly label: string;
  readonly key: string;             // the keyboard's letter
  readonly icon: string;            // of ui/icons.ts
  readonly hint: string;            // for the status bar
  /** Does the tool use the shift key? Else shift-drags pan. */
  readonly shift?: boolean;
  enter?(): void;
  leave?(): void;
  /** True when the tool takes the drag; else the camera does. */
  down(event: ToolEvent): boolean;
  move?(event: ToolEvent): void;    // with the button down
  hover?(event: ToolEvent): void;   // without
  up?(event: ToolEvent): void;
  /** True when the tool used the wheel; else the camera zooms. */
  wheel?(event: ToolEvent, delta: number): boolean;
  double?(event: ToolEvent): void;
  /** Escape, or the drag was taken away. */
  cancel?(): void;
  /** Does something wait, without a drag, for what comes next? */
  pending?(): boolean;
}
