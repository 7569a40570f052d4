// An exemplar in the hand: to set the size of the texture (2008, §4.1) or to paste it on top (§4.6).

import { Vector3 } from 'three';
import type { App } from '../app';
import { Refusal } from '../connection';
import type { Json, Packet } from '../protocol';
import { bodyKey, solidOf } from '../store';
import { write } from '../ui/numbers';
import { exemplarTexture } from '../view/looks';
import type { Ghost } from '../view/viewport';
import { toPoint } from './stroke';
import type { Hit, Tool, ToolEvent } from './tool';

/** The ghost that follows the hand; it stays where it was put until the tool is left. */
class Hand {
  ghost: Ghost | null = null;
  hit: Hit | null = null;
  private shown = '';

  constructor(private readonly app: App, private readonly exemplarOf: () => Json | null,
    private readonly radius: number,
              private readonly dropOff: number) {}

  /** Fetches the exemplar's voxels, when it is another than the one in the hand. */
  async take(): Promise<void> {
    const exemplar = this.exemplarOf(), text = JSON.stringify(exemplar);
    if (!exemplar || text === this.shown) return;
    this.shown = text;
    try {
      const packet = await this.app.connection.ask<Packet>('exemplar', { exemplar });
      if (text !== this.shown) return;
      this.ghost?.texture.dispose();
      const at = this.ghost;
      this.ghost = {
        texture: exemplarTexture(packet), point: at?.point ?? new Vector3(), up: at?.up ?? new Vector3(0, 0, 1),
        along: at?.along ?? new Vector3(1, 0, 0), size: this.size(), radius: this.radius, dropOff: this.dropOff,
      };
      if (this.hit) this.put(this.hit);
    } catch (reason) {
      this.shown = '';
      this.app.actions.complain(reason instanceof Refusal ? reason.message : String(reason));
    }
  }

  /** The size in the hand; a quarter of everything before one was chosen. */
  size(): number {
    const { store, viewport } = this.app;
    if (store.state.size === 0) store.set({ size: Number((viewport.diagonal / 4).toPrecision(3)) });
    return store.state.size;
  }

  /** Puts it at a place: s goes in at the skin, t along what was along before, as far as the surface lets it. */
  put(hit: Hit): void {
    this.hit = hit;
    const { ghost } = this;
    if (!ghost) return;
    const inwards = hit.normal.clone().negate(), flat = (v: Vector3): Vector3 => v.addScaledVector(inwards,
      -v.dot(inwards));
    let along = flat(ghost.along.clone());
    if (along.length() < 0.2) along =
      flat(new Vector3(Math.abs(inwards.x) < 0.7 ? 1 : 0, Math.abs(inwards.x) < 0.7 ? 0 : 1, 0));
    Object.assign(ghost, { point: hit.point.clone(), up: inwards, along: along.normalize() });
    this.show();
  }

  turn(angle: number): void {
    if (!this.ghost) return;
    this.ghost.along.applyAxisAngle(this.ghost.up, angle);
    this.show();
  }

  show(): void {
    const { viewport, store } = this.app;
    if (!this.ghost || !this.hit) return;
    this.ghost.size = this.size();
    viewport.ghost(this.ghost);
    viewport.overlay.show('ghost', [{ points: [this.hit.world], colour: '#ffffff', dots: 3,
      label: write(Number(store.state.size.toPrecision(3))) }]);
  }

  drop(): void {
    this.hit = null;
    this.app.viewport.ghost(null);
    this.app.viewport.overlay.show('ghost', null);
  }
}

/* What both tools do with the pointer; double-clicking does what `set` says. */
function placeTool(app: App, facts: Pick<Tool, 'name' | 'label' | 'key' | 'icon' | 'hint' | 'shift'>, hand: Hand,
  set: (hit: Hit, ghost: Ghost) => void): Tool {
  const { store } = app;
  let turning: number | null = null;
  store.on(['size', 'pasting', 'body', 'document'], () => {
    if (store.state.tool !== facts.name) return;
    void hand.take();
    hand.show();
  });
  return {
    ...facts,
    enter() {
      if (store.state.mode !== 'solid') store.set({ mode: 'solid' });
      void hand.take();
    },
    leave: () => hand.drop(),
    down(event) {
      if (facts.shift && event.pointer.shiftKey && hand.hit) {
        turning = event.x;
        return true;
      }
      const hit = event.hit();
      if (!hit) return false;
      store.set({ body: hit.body });
      hand.put(hit);
      return true;
    },
    move(event) {
      if (turning !== null) {
        hand.turn((event.x - turning) * 0.01);
        turning = event.x;
        return;
      }
      const hit = event.hit();
      if (hit) hand.put(hit);
    },
    up() { turning = null; },
    wheel(event: ToolEvent, delta: number) {
      if (!hand.hit || !event.hit()) return false;
      const size = hand.size() * Math.exp(-Math.max(-200, Math.min(200, delta)) * 0.0012);
      store.set({ size: Number(size.toPrecision(3)) });
      hand.show();
      return true;
    },
    double(event) {
      const hit = event.hit();
      if (!hit || !hand.ghost) return;
      hand.put(hit);
      set(hit, hand.ghost);
    },
    cancel() { turning = null; },
  };
}

/** Sets the size of the exemplar at places of the body. */
export function scaleTool(app: App): Tool {
  const { store, actions } = app;
  const hand = new Hand(app, () => (solidOf(store.state)?.json.exemplar ?? null) as Json | null, 0.5, 0);
  return placeTool(app, {
    name: 'scale', label: 'Texture size', key: 's', icon: 'scale',
    hint: 'Click to put the exemplar on the model, drag to move it, wheel for its size; a double click sets it there.',
  }, hand, (hit) => {
    void actions.apply('Set size', [{ op: 'scale.point', ...bodyKey(store.state, hit.body), point: toPoint(hit.point),
      size: store.state.size }]);
  });
}

/** Sets exemplars on top of the filled body. */
export function pasteTool(app: App): Tool {
  const { store, actions } = app;
  const chosen = (): Json | null =>
    store.state.pasting ?? (solidOf(store.state)?.json.exemplar as Json | undefined) ?? null;
  const hand = new Hand(app, chosen, 0.48, 0.075);
  return placeTool(app, {
    name: 'paste', label: 'Paste', key: 't', icon: 'paste', shift: true,
    hint: 'Click to put the exemplar on the model, drag to move, Shift to turn, wheel for its size; a double click pastes.',
  }, hand, (hit, ghost) => {
    void actions.apply('Paste', [{
      op: 'paste.add', ...bodyKey(store.state, hit.body), exemplar: chosen(), point: toPoint(hit.point),
      up: toPoint(ghost.up),
      along: toPoint(ghost.along), size: store.state.size,
    }]);
  });
}
