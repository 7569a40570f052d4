// A place to drop a file on, or to choose one.

import { button } from './controls';
import { h } from './dom';
import { icon } from './icons';

/** words: what is dropped there, as "voxels (.nrrd)"; accept: its extensions; take: is given the first file. */
export function dropZone(words: string, accept: string, take: (file: File) => void): HTMLElement {
  const first = (files: FileList | null | undefined): void => { if (files?.[0]) take(files[0]); };
  const picker = h('input', { type: 'file', accept, hidden: true, onchange: () => first(picker.files) });
  const zone = h('div', { class: 'drop' }, icon('upload', 22), h('span', null, `Drop ${words} here, or `),
    button('choose a file', () => picker.click()), picker);
  zone.addEventListener('dragover', (event) => { event.preventDefault(); zone.classList.add('over'); });
  zone.addEventListener('dragleave', () => zone.classList.remove('over'));
  zone.addEventListener('drop', (event) => {
    event.preventDefault();
    event.stopPropagation();
    zone.classList.remove('over');
    first(event.dataTransfer?.files);
  });
  return zone;
}
