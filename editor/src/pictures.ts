// Snapshots: pictures rendered by the server, from where the view's eye is, kept as long as the page is open.

import type { App } from './app';
import { Refusal } from './connection';
import type { Json } from './protocol';

export interface Snapshot {
  job: number;
  how: 'render' | 'volume';
  camera: Json;
  width: number;
  height: number;
  url: string | null;               // of the finest picture so far
  state: 'making' | 'done' | 'failed';
  name: string;
}

export class Pictures {
  readonly list: Snapshot[] = [];
  /** Called when the list, or a picture of it, changed. */
  onChange: (() => void)[] = [];

  constructor(private readonly app: App) {
    app.model.onPicture.push((picture) => {
      const shot = this.list.find((each) => each.job === picture.job);
      if (!shot) return;
      if (shot.url) URL.revokeObjectURL(shot.url);
      shot.url = URL.createObjectURL(new Blob([picture.png as Uint8Array<ArrayBuffer>], { type: 'image/png' }));
      if (picture.final) shot.state = 'done';
      this.changed();
    });
    app.store.on(['jobs'], () => this.watchJobs());
  }

  /** Takes a picture from where the eye is now; sizes and options left out are the document's. */
  async take(how: 'render' | 'volume', width: number, height: number): Promise<void> {
    const { connection, viewport, actions, store } = this.app;
    const camera = viewport.table.toDocument();
    try {
      const { job } = await connection.ask('picture', { how, camera, width, height });
      const name = `${(store.state.file || 'picture').replace(/\.pith$/, '')}-${this.list.length + 1}.png`;
      this.list.unshift({ job, how, camera, width, height, url: null, state: 'making', name });
      store.set({ tab: 'look' });
      this.changed();
    } catch (reason) {
      actions.complain(reason instanceof Refusal ? reason.message : String(reason));
    }
  }

  /** Takes a picture out of the list, and stops its making. */
  remove(shot: Snapshot): void {
    if (shot.state === 'making') void this.app.actions.cancel(shot.job);
    if (shot.url) URL.revokeObjectURL(shot.url);
    this.list.splice(this.list.indexOf(shot), 1);
    this.changed();
  }

  private watchJobs(): void {
    for (const job of this.app.store.state.jobs) {
      const shot = this.list.find((each) => each.job === job.job);
      if (shot && shot.state === 'making' && (job.state === 'failed' || job.state === 'cancelled')) {
        shot.state = 'failed';
        this.changed();
      }
    }
  }

  private changed(): void { for (const call of this.onChange) call(); }
}
