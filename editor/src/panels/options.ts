// Rows for the plain values of any object of the document, made from the schema: nothing here knows what they mean.

import { removeValue, setValue, type App } from '../app';
import type { Json } from '../protocol';
import { plainFields, valueAt, type Field } from '../schema';
import { checkbox, choice, colourField, iconButton, row, segmented, textField } from '../ui/controls';
import { h, live, uid } from '../ui/dom';
import { slider } from '../ui/slider';
import { section } from '../ui/layout';

export interface OptionSettings {
  /** These keys and no others, in this order; without it all plain ones. */
  only?: string[];
  skip?: string[];
  /** Keys under a fold, "More". */
  more?: string[];
  /** The stretch of sliders whose limits are far beyond what is used, in the document's units. */
  soft?: { [key: string]: [low: number, high: number] };
  /** Whose they are, in the names of steps: "Set fill drop off". */
  of?: string;
}

/** Rows of a place, kept in step with the document; empty while the schema knows nothing there. */
export function optionRows(app: App, place: string, settings: OptionSettings = {}): HTMLElement {
  const host = h('div', { class: 'rows' });
  live(app.store, host, ['document', 'schema'], (state) => {
    const fields = chosen(plainFields(state.schema, state.document, place), settings);
    return { fields, values: fields.map((field) => valueAt(state.document, join(place, field.key))) };
  }, ({ fields, values }) => {
    const rows = fields.map((field, i) => optionRow(app, place, field, values[i], settings));
    const first = rows.filter((_, i) => !settings.more?.includes(fields[i].key));
    const rest = rows.filter((_, i) => settings.more?.includes(fields[i].key));
    if (rest.length === 0) return first;
    const fold = section(`more.${place.replace(/\d+/g, '')}`, 'More', { folded: true, inner: true });
    fold.body.append(...rest);
    return [first, fold.element];
  });
  return host;
}

/** The path of a key at a place; the document itself is ''. */
export function join(place: string, key: string): string {
  return place === '' || place.endsWith('.') ? place + key : `${place}.${key}`;
}

function chosen(fields: Field[], settings: OptionSettings): Field[] {
  if (!settings.only) return fields.filter((field) => !settings.skip?.includes(field.key));
  return settings.only.map((key) => fields.find((field) => field.key === key)).filter((field) => field !== undefined);
}

/** One row: label, control and, once it is set, the way back to the default. */
export function optionRow(app: App, place: string, field: Field, value: unknown,
  settings: OptionSettings = {}): HTMLElement {
  const path = join(place, field.key), id = uid();
  const name = `${settings.of ? `${settings.of} ` : ''}${field.label.toLowerCase()}`;
  const given = value !== undefined;
  const reset = (): void => { if (given && !field.required) void removeValue(app, `Reset ${name}`, path); };
  const commit = async (next: unknown): Promise<void> => {
    const back = next === field.default && !field.required;
    const done = back ? given ? removeValue(app, `Reset ${name}`, path) : true
      : setValue(app, `Set ${name}`, path, next);
    if (!(await done)) control.set((value ?? field.default) as never);
  };
  const control = controlOf(field, value ?? field.default, (next) => void commit(next),
    { path, id, reset, soft: settings.soft });
  const made = row(field.label, control.element, { tip: field.help, for: control.labelled ? id : undefined,
    wide: control.wide });
  if (given && field.default !== undefined && !field.required && value !== field.default) {
    made.classList.add('given');
    made.prepend(iconButton('return', `Back to ${String(field.default)}`, reset,
      { look: 'plain', class: 'row-reset', key: `${path}!` }));
  }
  return made;
}

interface Made { element: HTMLElement; set(value: never): void; labelled: boolean; wide?: boolean }

function controlOf(field: Field, value: any, commit: (value: unknown) => void,
  at: { path: string; id: string; reset: () => void; soft?: OptionSettings['soft'] }): Made {
  const key = at.path, id = at.id;
  switch (field.kind) {
    case 'number': {
      const seed = field.whole && field.max > 1e12;
      const spec = { ...field, default: field.default as number | undefined, soft: at.soft?.[field.key] };
      const made = slider(field.label, spec, value ?? field.min, commit, { key, id, reset: at.reset, bare: seed });
      if (seed) {
        made.element.append(iconButton('dice', 'Another one', () => commit(1 + Math.floor(Math.random() * 9999)),
          { key: `${key}?` }));
      }
      return { ...made, labelled: true };
    }
    case 'yes': {
      const made = checkbox('', value ?? false, commit, { key, look: 'switch' });
      made.element.querySelector('input')!.id = id;
      return { ...made, labelled: true };
    }
    case 'choice': {
      const choices = field.choices.map((each) => ({ value: each, label: each }));
      const short = choices.length <= 3 && field.choices.join('').length < 18;
      if (short) return { ...segmented(field.label, choices, value, commit, { key }), labelled: false };
      return { ...choice(field.label, choices, value, commit, { key, id }), labelled: true };
    }
    case 'colour': return { ...colourField(field.label, value ?? '#000000', commit, { key, id }), labelled: true };
    default: return { ...textField(field.label, value ?? '', commit, { key, id }), labelled: true };
  }
}

/** An object of defaults for a new entry of a list: what is required, with plain values that the schema gives. */
export function freshEntry(fields: Field[], given: Json): Json {
  const entry: Json = { ...given };
  for (const field of fields) {
    if (field.required && !(field.key in entry) && field.default !== undefined) entry[field.key] = field.default;
  }
  return entry;
}
