// The Volume view: the model seen through, as the server renders it, laid over the view. Coarse pictures follow a camera
// that moves; when it has come to rest one of the view's own size is asked for.

import type { App } from './app';
import { Refusal } from './connection';

const rest = 350;                   // ms without a move until the camera rests
const coarse = 0.25, largest = 1600; // of the view's size while it moves; pixels along a side

/** Puts the pictures over the view whenever the page is in the Volume view. */
export function installVolumeView(app: App): void {
  const { store, viewport, connection, actions } = app;
  const image = document.createElement('img');
  image.className = 'volume-picture';
  image.alt = 'The model seen through';
  image.hidden = true;
  viewport.canvas.after(image);
  const jobs = new Set<number>();
  let asked = '', asking = false, again = false, timer = 0;

  const inView = (): boolean => store.state.mode === 'volume';

  async function ask(scale: number): Promise<void> {
    if (asking) {
      again = true;
      return;
    }
    const { clientWidth, clientHeight } = viewport.element;
    if (!inView() || clientWidth === 0) return;
    const size = Math.min(scale, largest / Math.max(clientWidth, clientHeight));
    asking = true;
    try {
      const { job } = await connection.ask('picture', {
        how: 'volume', stream: 'volume', camera: viewport.table.toDocument(), width: Math.max(16, Math.round(clientWidth * size)),
        height: Math.max(16, Math.round(clientHeight * size)), transparent: true,
        ...(scale < 1 ? { samples: 1, slices: 80 } : {}),
      });
      jobs.add(job);
    } catch (reason) {
      if (!(reason instanceof Refusal && reason.status === 'superseded')) actions.complain((reason as Error).message);
    }
    asking = false;
    if (again) {
      again = false;
      void ask(scale);
    }
  }

  /* What the picture shows: the camera, the size, and which state of the model. */
  function refresh(): void {
    if (!inView()) return;
    const { clientWidth, clientHeight } = viewport.element;
    const now = JSON.stringify([viewport.table.toDocument(), clientWidth, clientHeight, store.state.serial, store.state.revision]);
    if (now === asked) return;
    asked = now;
    clearTimeout(timer);
    timer = window.setTimeout(() => void ask(1), rest);
    void ask(coarse);
  }

  app.model.onPicture.push((picture) => {
    if (!jobs.has(picture.job)) return;
    if (picture.final) jobs.delete(picture.job);
    if (!inView()) return;
    const old = image.src;
    image.src = URL.createObjectURL(new Blob([picture.png as Uint8Array<ArrayBuffer>], { type: 'image/png' }));
    if (old.startsWith('blob:')) URL.revokeObjectURL(old);
    image.hidden = false;
    viewport.canvas.style.visibility = 'hidden';
  });
  viewport.onDraw.push(refresh);
  store.on(['mode', 'serial', 'revision'], () => {
    if (!inView()) {
      image.hidden = true;
      viewport.canvas.style.visibility = '';
      asked = '';
    }
    refresh();
  });
}
