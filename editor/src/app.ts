// Everything of the page that the parts of it share, and the verbs they change the document with.

import type { Actions } from './actions';
import type { Connection } from './connection';
import type { Model } from './model';
import type { Json } from './protocol';
import { bodyKey, type Store } from './store';
import type { Toolbox } from './tools/toolbox';
import type { Messages } from './ui/dialog';
import type { Viewport } from './view/viewport';

/** Times of things that go to the server and come back as a picture; benchmarks read them. */
export class Timing {
  readonly done: { [name: string]: { sent: number; arrived: number; drawn: number; bytes: number; server: { [stage: string]: number } }[] } = {};
  private running: { name: string; sent: number } | null = null;
  private arrived: { name: string; sent: number; arrived: number; bytes: number; server: { [stage: string]: number } } | null = null;

  begin(name: string): void { this.running = { name, sent: performance.now() }; }
  view(bytes: number, server: { [stage: string]: number }): void {
    if (!this.running) return;
    this.arrived = { ...this.running, arrived: performance.now(), bytes, server };
    this.running = null;
  }
  drawn(): void {
    if (!this.arrived) return;
    const { name, ...times } = this.arrived;
    (this.done[name] ??= []).push({ ...times, drawn: performance.now() });
    this.arrived = null;
  }
}

export interface App {
  store: Store;
  connection: Connection;
  actions: Actions;
  model: Model;
  messages: Messages;
  viewport: Viewport;
  toolbox: Toolbox;
  timing: Timing;
  /** Parts at their offsets, or all in one place: a cutting stroke goes through the model as one body. */
  assemble(on: boolean): void;
}

/** Sets a value of the document, as a step called `name`. */
export function setValue(app: App, name: string, path: string, value: unknown): Promise<boolean> {
  return app.actions.apply(name, [{ op: 'set', path, value }]);
}

/** Takes a value of the document away, as a step called `name`. */
export function removeValue(app: App, name: string, path: string): Promise<boolean> {
  return app.actions.apply(name, [{ op: 'remove', path }]);
}

/** Does operations of the chosen body, as a step called `name`; the body's name is added to each. */
export function operate(app: App, name: string, ...operations: Json[]): Promise<boolean> {
  const body = bodyKey(app.store.state);
  return app.actions.apply(name, operations.map((operation) => ({ ...operation, ...body })));
}
