// The dialog of a file that a document names: those beside it, those shipped, and one that is dropped in.

import type { App } from '../app';
import { fill, h } from '../ui/dom';
import { openDialog } from '../ui/dialog';
import { dropZone } from '../ui/dropzone';
import { icon } from '../ui/icons';
import { upload } from './files';

interface Shown { path: string; name: string; shipped: boolean }

const kinds = {
  image: { title: 'Picture', accept: '.png,.jpg,.jpeg', words: 'a picture (.png, .jpg)' },
  mesh: { title: 'Mesh', accept: '.glb,.ply,.obj,.stl,.off', words: 'a mesh (.glb, .ply, .obj, .stl, .off)' },
  grid: { title: 'Voxels', accept: '.nrrd', words: 'voxels (.nrrd)' },
};

/** Opens the dialog; `chosen` is told the path as a document writes it. */
export function fileDialog(app: App, kind: keyof typeof kinds, chosen: (path: string) => void): void {
  const { title, accept, words } = kinds[kind];
  const lists = h('div', { class: 'files' }, h('p', { class: 'quiet' }, 'Looking for files…'));
  const drop = dropZone(words, accept, (file) => void take(file));
  const use = (path: string): void => { close(); chosen(path); };
  async function take(file: File): Promise<void> {
    const path = await upload(app, file);
    if (path) use(path);
  }
  const group = (name: string, files: Shown[]): HTMLElement | null => (files.length === 0 ? null
    : h('section', { class: 'file-group' }, h('h3', null, name), h('ul', { class: 'file-list' }, files.map((file) =>
      h('li', null, h('button', { type: 'button', class: 'file', 'data-tip': file.path, onclick: () => use(file.path) },
        icon(kind === 'image' ? 'image' : 'solid', 26), h('span', null, file.path.split('/').pop()!)))))));
  const close = openDialog({ title, body: [drop, lists], class: 'wide' });
  app.connection.ask('files', { kind }).then(({ files }: { files?: Shown[] }) => {
    const all = files ?? [];
    fill(lists, all.length === 0 && h('p', { class: 'quiet' }, 'There is none yet, beside the document or among what comes with pith.'),
      group('In the document’s folder', all.filter((each) => !each.shipped)),
      group('Shipped with pith', all.filter((each) => each.shipped)));
  }, (reason: Error) => fill(lists, h('p', { class: 'quiet' }, reason.message)));
}
