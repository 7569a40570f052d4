// Saving: under the document's own name, under another, and over what somebody else has written meanwhile.

import type { App } from '../app';
import { button } from '../ui/controls';
import { h } from '../ui/dom';
import { askText, openDialog, type Objection } from '../ui/dialog';

/** Saves; when the file is not what it was, asks what to do. */
export async function save(app: App, force = false): Promise<void> {
  const file = await app.actions.save(force ? { force } : {}, (message, status) => {
    if (status === 'changed on disk') void changedOnDisk(app);
    else app.actions.complain(message, status);
  });
  if (file) app.messages.say(`Saved ${file}.`, 'done');
}

async function changedOnDisk(app: App): Promise<void> {
  const { file } = app.store.state, there = await isThere(app, file);
  const about = there
    ? `Another program has changed ${file} since it was read. “Save anyway” replaces it with what is here; ` +
      '“Revert to the file” takes what is in it, which can be undone.'
    : `${file} is not where it was: another program has removed it. “Save anyway” writes it again.`;
  const choose = (act: () => Promise<unknown>) => (): void => { close(); void act(); };
  const close = openDialog({ title: 'Changed on disk', class: 'small', body: h('p', null, about), actions: [
    button('Cancel', () => close()),
    there && button('Revert to the file', choose(() => app.actions.revert())),
    button('Save anyway', choose(() => save(app, true)), { look: 'danger' }),
  ] });
}

/* Is the document's file among those of its folder? */
async function isThere(app: App, file: string): Promise<boolean> {
  try {
    const { files } = await app.connection.ask('files', { kind: 'document' });
    return (files as { path: string; shipped: boolean }[]).some((each) => !each.shipped && each.path === file);
  } catch {
    return true; // nothing is known against it
  }
}

/** Asks for a name and saves under it. */
export function saveAs(app: App): void {
  askText({ title: 'Save as', label: 'File name, in the document’s folder', value: app.store.state.file, act: 'Save',
    none: 'Type a name for the file.', run: (name, force) => saveUnder(app, name, force) });
}

async function saveUnder(app: App, name: string, force: boolean): Promise<Objection | null> {
  const file = /\.[^./]*$/.test(name) ? name : `${name}.pith`, own = app.store.state.file;
  let objection: Objection | null = null;
  const saved = await app.actions.save({ file, ...(force ? { force } : {}) }, (message, status) => {
    const insist = status === 'changed on disk' ? 'Save anyway' : / already\b/.test(message) ? 'Replace' : undefined;
    objection = { why: message, insist };
  });
  if (saved) {
    app.messages.say(saved === own ? `Saved ${saved}.` : `Saved ${saved}, a copy; this page goes on with ${own}.`, 'done');
  }
  return objection;
}
