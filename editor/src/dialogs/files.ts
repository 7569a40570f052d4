// The dialog of exemplars: those in the document's folder, those shipped, and files that are dropped in.

import { setValue, type App } from '../app';
import type { Json } from '../protocol';
import { solidOf } from '../store';
import { fill, h, set } from '../ui/dom';
import { openDialog } from '../ui/dialog';
import { dropZone } from '../ui/dropzone';
import { Cube, exemplarName } from '../panels/exemplars';

interface Entry { path: string; name: string; shipped: boolean; kind: 'recipe' | 'grid' }

const exemplarOf = (entry: { path: string; kind: string }): Json =>
  (entry.kind === 'recipe' ? { recipe: entry.path } : { file: entry.path });

const kindOf = (path: string): Entry['kind'] => (/\.json$/i.test(path) ? 'recipe' : 'grid');

/** Puts files dropped on the page beside the document, and offers exemplars among them to the chosen body. Without it
    the browser would leave the page for the file. */
export function takeDroppedFiles(app: App): void {
  window.addEventListener('dragover', (event) => event.preventDefault());
  window.addEventListener('drop', async (event) => {
    event.preventDefault();
    for (const file of event.dataTransfer?.files ?? []) {
      const path = await upload(app, file), solid = solidOf(app.store.state);
      if (!path) continue;
      const use = /\.(json|nrrd)$/i.test(path) && solid?.json.kind === 'lapped'
        ? { label: 'Use it', run: () => void useDropped(app, path, solid.place) } : undefined;
      app.messages.say(`${path} is beside the document now.`, 'done', use);
    }
  });
}

async function useDropped(app: App, path: string, place: string): Promise<void> {
  const exemplar = exemplarOf({ path, kind: kindOf(path) }), why = await obstacle(app, exemplar);
  if (why) app.actions.complain(cannotBeUsed(path, why));
  else await setValue(app, `Take ${exemplarName(exemplar)}`, `${place}.exemplar`, exemplar);
}

const cannotBeUsed = (path: string, why: string): string => `${path} cannot be used. ${why}`;

/* Why the server cannot read an exemplar; null when it can. */
function obstacle(app: App, exemplar: Json): Promise<string | null> {
  return app.model.exemplar({ exemplar }).then(() => null, (reason: Error) => reason.message);
}

/** Opens the dialog; `chosen` is told what was taken, as a document writes it. */
export function exemplarDialog(app: App, title: string, chosen: (exemplar: Json) => void): void {
  const lists = h('div', { class: 'files' }, h('p', { class: 'quiet' }, 'Looking for files…'));
  const drop = dropZone('a recipe (.json) or voxels (.nrrd)', '.json,.nrrd', (file) => void take(file));
  const why = h('p', { class: 'objection', role: 'alert' });
  const use = (entry: { path: string; kind: string }): void => { close(); chosen(exemplarOf(entry)); };
  async function take(file: File): Promise<void> {
    const path = await upload(app, file);
    if (!path) return;
    const entry = { path, kind: kindOf(path) }, refused = await obstacle(app, exemplarOf(entry));
    if (refused) why.textContent = cannotBeUsed(path, refused);
    else use(entry);
  }
  const close = openDialog({ title, body: [drop, why, lists], class: 'wide' });
  void load(app).then((entries) => fill(lists,
    group(app, 'In the document’s folder', entries.filter((each) => !each.shipped), use),
    group(app, 'Shipped with pith', entries.filter((each) => each.shipped), use)),
  (reason: Error) => fill(lists, h('p', { class: 'quiet' }, reason.message)));
}

async function load(app: App): Promise<Entry[]> {
  const kinds = ['recipe', 'grid'] as const;
  const answers = await Promise.all(kinds.map((kind) => app.connection.ask('files', { kind })));
  return answers.flatMap(({ files }, i) => (files as Entry[]).map((file) => ({ ...file, kind: kinds[i] })));
}

/** Sends a file into the document's folder; null when that was refused, which has been said. */
export async function upload(app: App, file: File): Promise<string | null> {
  try {
    const { path } = await app.connection.upload('file.put', { name: file.name },
      new Uint8Array(await file.arrayBuffer()));
    return path as string;
  } catch (reason) {
    app.actions.complain((reason as Error).message);
    return null;
  }
}

function group(app: App, name: string, entries: Entry[], use: (entry: Entry) => void): HTMLElement | null {
  if (entries.length === 0) return null;
  return h('section', { class: 'file-group' }, h('h3', null, name),
    h('ul', { class: 'file-list' }, entries.map((entry) => h('li', null, card(app, entry, use)))));
}

/* A file's cube is asked for when it comes into sight. One that cannot be read says why in its place, and is not taken. */
function card(app: App, entry: Entry, use: (entry: Entry) => void): HTMLButtonElement {
  const cube = new Cube(app, 64), exemplar = exemplarOf(entry);
  let asked: Promise<string | null> | null = null;
  const ask = (): Promise<string | null> => (asked ??= cube.show({ exemplar }, null).then((refused) => {
    if (!refused) return null;
    set(made, 'aria-disabled', true);
    made.dataset.tip = refused;
    cube.canvas.replaceWith(h('span', { class: 'file-why' }, refused));
    return refused;
  }));
  const made = h('button', { type: 'button', class: 'file', 'data-tip': entry.path,
    onclick: async () => { if (!await ask()) use(entry); } }, cube.canvas, h('span', null, exemplarName(exemplar)));
  const seen = new IntersectionObserver(([at]) => {
    if (!at.isIntersecting) return;
    seen.disconnect();
    void ask();
  });
  seen.observe(cube.canvas);
  return made;
}
