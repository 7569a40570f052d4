// The tools and the pointer: who gets a drag, the tool or the camera.

import type { Vector3 } from 'three';
import type { Store, ToolName } from '../store';
import type { Viewport } from '../view/viewport';
import type { Hit, Tool, ToolEvent } from './tool';

export class Toolbox {
  readonly tools: Tool[] = [];
  private taken = new Set<number>();    // pointers whose drag a tool has
  private camera = new Set<number>();   // pointers whose drag the camera has
  private hovering: PointerEvent | null = null;

  constructor(private readonly store: Store, private readonly viewport: Viewport) {
    const { element } = viewport;
    element.addEventListener('pointerdown', (event) => this.down(event));
    element.addEventListener('pointermove', (event) => this.move(event));
    element.addEventListener('pointerup', (event) => this.up(event));
    element.addEventListener('pointercancel', (event) => this.lost(event));
    element.addEventListener('pointerleave', () => { this.hovering = null; });
    element.addEventListener('dblclick', (event) => this.current?.double?.(this.eventOf(event)));
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    store.on(['tool'], () => this.enter());
  }

  add(...tools: Tool[]): void { this.tools.push(...tools); }

  get(name: ToolName): Tool | undefined { return this.tools.find((tool) => tool.name === name); }

  get current(): Tool | undefined { return this.entered; }
  private entered: Tool | undefined;

  /** Takes up the tool that the store names. */
  enter(): void {
    const next = this.get(this.store.state.tool);
    if (next === this.entered) return;
    this.cancel();
    this.entered?.leave?.();
    this.entered = next;
    next?.enter?.();
    this.store.set({ hint: next?.hint ?? '' });
    this.viewport.element.dataset.tool = next?.name ?? '';
  }

  /** Has a tool a drag, or something under way? */
  get busy(): boolean { return this.taken.size > 0 || this.entered?.pending?.() === true; }

  /** Ends what is under way without doing it. */
  cancel(): void {
    this.taken.clear();
    this.entered?.cancel?.();
  }

  private eventOf(pointer: PointerEvent | WheelEvent | MouseEvent): ToolEvent {
    const place = this.viewport.element.getBoundingClientRect();
    const x = pointer.clientX - place.left, y = pointer.clientY - place.top;
    let known: Hit | null | undefined;
    let ray: { origin: Vector3; direction: Vector3 } | undefined;
    return {
      x, y, pointer,
      hit: () => (known === undefined ? (known = this.viewport.hit(x, y)) : known),
      ray: () => (ray ??= this.viewport.ray(x, y)),
    };
  }

  private down(event: PointerEvent): void {
    const { hands, canvas } = this.viewport;
    canvas.focus({ preventScroll: true });
    this.viewport.element.setPointerCapture(event.pointerId);
    hands.press(event);
    // A second finger turns a drag of a tool into one of the camera.
    if (hands.fingers > 1) {
      if (this.taken.size > 0) this.cancel();
      this.camera.add(event.pointerId);
      return;
    }
    const plain = event.button === 0 && !event.altKey && !(event.shiftKey && event.pointerType === 'mouse' && !this.entered?.shift);
    if (plain && this.entered?.down(this.eventOf(event))) this.taken.add(event.pointerId);
    else this.camera.add(event.pointerId);
  }

  private move(event: PointerEvent): void {
    if (this.taken.has(event.pointerId)) this.entered?.move?.(this.eventOf(event));
    else if (this.viewport.hands.fingers > 0) this.viewport.hands.drag(event);
    else this.hover(event);
  }

  /* Hovering looks for what is under the pointer, so it is done once a frame. */
  private hover(event: PointerEvent): void {
    if (!this.entered?.hover) return;
    if (this.hovering === null) requestAnimationFrame(() => {
      const last = this.hovering;
      this.hovering = null;
      if (last && this.taken.size === 0 && this.viewport.hands.fingers === 0) this.entered?.hover?.(this.eventOf(last));
    });
    this.hovering = event;
  }

  private up(event: PointerEvent): void {
    this.viewport.hands.release(event);
    if (this.taken.delete(event.pointerId)) this.entered?.up?.(this.eventOf(event));
    this.camera.delete(event.pointerId);
  }

  private lost(event: PointerEvent): void {
    this.viewport.hands.release(event);
    this.camera.delete(event.pointerId);
    if (this.taken.delete(event.pointerId)) this.entered?.cancel?.();
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const at = this.eventOf(event);
    if (!event.ctrlKey && this.entered?.wheel?.(at, event.deltaY)) return;
    this.viewport.hands.wheel(event, at.x, at.y);
  }
}
