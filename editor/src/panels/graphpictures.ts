// Small pictures of what nodes give: on a square through the middle of the body, asked when they come into sight.

import type { App } from '../app';
import { Graph } from '../graph';
import type { Json, Packet } from '../protocol';
import { bodyKey, solidOf } from '../store';
import { h, set } from '../ui/dom';
import { icon } from '../ui/icons';
import { write } from '../ui/numbers';

const side = 64;                    // pixels asked for
const wait = 250;                   // ms after a change until pictures are asked for again

export class NodePictures {
  private readonly shown = new Map<string, { canvas: HTMLCanvasElement; frame: HTMLElement; of: string; seen: boolean }>();
  private asking = false;
  private timer = 0;
  private readonly sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const own = this.shown.get((target as HTMLElement).dataset.node!);
      if (own && own.frame === target) own.seen = isIntersecting;
    }
    this.soon(0);
  });

  constructor(private readonly app: App) {
    app.store.on(['document', 'body', 'connection', 'serial'], () => this.soon(wait));
  }

  /** The picture of a node, kept in step with the document; the same element for the same name. */
  canvas(name: string, word: string): HTMLElement {
    const known = this.shown.get(name);
    if (known) return known.frame;
    const canvas = h('canvas', { width: side, height: side, role: 'img', 'aria-label': `What ${name} gives`, hidden: true });
    const frame = h('span', { class: 'node-picture', 'data-node': name, 'data-tip': word }, icon('noise', 18), canvas);
    this.shown.set(name, { canvas, frame, of: '', seen: false });
    this.sight.observe(frame);
    return frame;
  }

  private soon(delay: number): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.refresh(), delay);
  }

  /* One after another: whatever changed meanwhile is asked for again. */
  private async refresh(): Promise<void> {
    if (this.asking) return this.soon(wait);
    this.asking = true;
    const { state } = this.app.store, solid = solidOf(state)?.json, square = this.square();
    if (solid?.nodes && square && state.connection === 'open') {
      const graph = new Graph(solid, state.functions);
      for (const [name, own] of this.shown) {
        if (graph.indexOf(name) < 0 || !own.frame.isConnected) this.forget(name);
        else if (own.seen && state.document === this.app.store.state.document) await this.show(name, graph, square);
      }
    }
    this.asking = false;
    if (state.document !== this.app.store.state.document) this.soon(0);
  }

  private forget(name: string): void {
    const own = this.shown.get(name);
    if (own) this.sight.unobserve(own.frame);
    this.shown.delete(name);
  }

  private async show(name: string, graph: Graph, square: Json): Promise<void> {
    const own = this.shown.get(name)!, { store, connection } = this.app;
    const nodes = [...graph.behind(name)].map((each) => graph.nodes[graph.indexOf(each)]);
    const of = JSON.stringify([nodes, graph.solid.seed, square]);
    if (own.of === of) return;
    try {
      const { head, arrays } = await connection.ask<Packet>('node', { ...bodyKey(store.state), node: name, size: side, ...square });
      const pixels = new ImageData(new Uint8ClampedArray(arrays.pixels as Uint8Array), side, side);
      own.canvas.getContext('2d')!.putImageData(pixels, 0, 0);
      own.of = of;
      own.canvas.hidden = false;
      set(own.frame, 'data-tip', rangeWord(head));
    } catch (reason) {
      own.canvas.hidden = true;
      set(own.frame, 'data-tip', (reason as Error).message);
      own.of = of;
    }
  }

  /* Upright through the middle of the body, as seen from the front, as large as lies within its box; rounded, so that a
     cut or a stroke asks for nothing anew. */
  private square(): Json | null {
    const mesh = this.app.model.meshes.get(this.app.store.state.body);
    if (!mesh?.box) return null;
    const [low, high] = mesh.box, edge = Number(Math.min(high[0] - low[0], high[2] - low[2]).toPrecision(4));
    if (!(edge > 0)) return null;
    const middle = low.map((least, k) => Number(((least + high[k]) / 2).toPrecision(4)));
    return { corner: [middle[0] - edge / 2, middle[1], middle[2] - edge / 2], along: [edge, 0, 0], up: [0, 0, edge] };
  }
}

/* What the picture's colours mean. */
function rangeWord(head: Json): string {
  const ranges = head.range as [number, number][], words = ranges.map(([low, high]) => `${write(low)} to ${write(high)}`);
  if (head.gives === 'point') return `x ${words[0]}, y ${words[1]}, z ${words[2]}`;
  return head.gives === 'number' && words.length > 0 ? words[0] : 'A colour';
}
