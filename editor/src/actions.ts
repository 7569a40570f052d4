// What a person can do to the document, each a request to the server; refusals end up as a message on the page.

import { Connection, Refusal } from './connection';
import type { Json } from './protocol';
import type { Store } from './store';

export class Actions {
  /** Shows a refusal to people; the status says of which kind it is. */
  complain: (message: string, status?: string) => void = () => {};

  private last: Promise<unknown> = Promise.resolve();

  constructor(readonly connection: Connection, private readonly store: Store) {}

  /** Does operations under a name, after those asked for before; false when they were refused. */
  apply(name: string, operations: Json[]): Promise<boolean> {
    return this.inTurn(() => this.connection.ask('apply', { revision: this.store.state.revision, name, operations }));
  }
  /** When all that was asked for before has been answered, and the page knows what came of it. */
  async settled(): Promise<void> { await this.last; }
  undo(): Promise<boolean> { return this.inTurn(() => this.connection.ask('undo', { revision: this.store.state.revision })); }
  redo(): Promise<boolean> { return this.inTurn(() => this.connection.ask('redo', { revision: this.store.state.revision })); }
  revert(): Promise<boolean> { return this.inTurn(() => this.connection.ask('revert', { revision: this.store.state.revision })); }
  /** Saves; gives the file that was written, null when it was refused. `refused` is told of that instead of `complain`. */
  async save(keys: Json, refused: (message: string, status?: string) => void): Promise<string | null> {
    let file: string | null = null;
    await this.inTurn(async () => {
      const answer = await this.connection.ask('save', keys);
      file = answer.file;
      return answer;
    }, refused);
    return file;
  }
  update(what: 'fields' | 'solid'): Promise<boolean> { return this.try(this.connection.ask('update', { what })); }
  cancel(job: number): Promise<boolean> { return this.try(this.connection.ask('cancel', { job })); }
  automatic(on: boolean): Promise<boolean> { return this.try(this.connection.ask('automatic', { on })); }

  /** Awaits a request and complains when it is refused. */
  async try(request: Promise<unknown>, refused = this.complain): Promise<boolean> {
    try {
      await request;
      return true;
    } catch (reason) {
      if (reason instanceof Refusal) refused(reason.message, reason.status);
      else refused(String(reason));
      return false;
    }
  }

  /* Changes carry the revision they were made on, so each waits for the one before: its answer and its event. */
  private inTurn(request: () => Promise<Json>, refused?: (message: string, status?: string) => void): Promise<boolean> {
    const turn = this.last.then(() => this.try(request().then((answer) => this.reached(answer.revision)), refused));
    this.last = turn;
    return turn;
  }

  private reached(revision: number | undefined): Promise<void> | void {
    if (revision === undefined || this.store.state.revision >= revision) return;
    return new Promise((resolve) => {
      const stop = this.store.on(['revision'], () => {
        if (this.store.state.revision < revision) return;
        stop();
        resolve();
      });
    });
  }
}
