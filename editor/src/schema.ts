// What may stand at a place of the document: limits, defaults and help, from the JSON Schema that the server sends.

import type { Json } from './protocol';

export type FieldKind = 'number' | 'yes' | 'choice' | 'colour' | 'text' | 'other';

/** A key of an object, as a field of the page needs it. */
export interface Field {
  key: string;
  label: string;
  help: string;                     // a sentence for the tooltip, limits and default included
  kind: FieldKind;
  whole: boolean;
  min: number;
  max: number;
  unit: string;
  default: unknown;                 // undefined: there is none
  choices: string[];
  required: boolean;
}

/** The steps of a path such as `bodies[1].solids[0].exemplar`. */
export function pathSteps(path: string): (string | number)[] {
  return [...path.matchAll(/([^.[\]]+)|\[(\d+)\]/g)].map(([, key, index]) =>
    (index === undefined ? key : Number(index)));
}

/** What stands at a place of the document; undefined when nothing does. */
export function valueAt(document: Json, path: string): any {
  let value: any = document;
  for (const step of pathSteps(path)) value = value?.[step];
  return value;
}

/** The schema of a place of the document, references followed and the alternative taken that the document's own
    `kind` or `function` names; null when nothing may stand there. A place that is not there yet has a schema all the same. */
export function schemaAt(schema: Json, document: Json, path: string): Json | null {
  let node: Json | null = resolve(schema, schema, document), value: any = document;
  for (const step of pathSteps(path)) {
    value = value?.[step];
    const inner: Json | undefined = typeof step === 'number' ? node?.items : node?.properties?.[step];
    if (!inner) return null;
    node = resolve(schema, inner, value);
  }
  return node;
}

/* Follows $ref, keeping the description of the place over that of the definition, and chooses among kinds. */
function resolve(root: Json, node: Json, value: any): Json {
  let found = node;
  if (typeof node.$ref === 'string') {
    const definition = pathSteps(node.$ref.replace(/^#\//, '').replaceAll('/', '.'))
      .reduce((at: any, step) => at?.[step], root) as Json;
    found = { ...definition, ...node, about: definition.description };
  }
  // A body like another may have every key that one of its own has, though it need not.
  if (found.else) return resolve(root, found.else as Json, value);
  const kinds = (found.oneOf as Json[] | undefined)?.map((each) => resolve(root, each, value))
    .filter((each) => each.properties);
  if (!found.properties && kinds?.length) {
    const suits = ([key, inner]: [string, any]): boolean => !('const' in inner) || inner.const === value?.[key];
    return kinds.find((each) => Object.entries(each.properties).every(suits)) ?? kinds[0];
  }
  return found;
}

/** The keys of the object at a place, in the schema's order. */
export function fieldsAt(schema: Json, document: Json, path: string): Field[] {
  const node = schemaAt(schema, document, path);
  const required = (node?.required ?? []) as string[];
  return Object.entries((node?.properties ?? {}) as Json).map(([key, inner]) =>
    fieldOf(key, resolve(schema, inner as Json, undefined), required.includes(key)));
}

/** The values of the object at a place that a row of the page can hold. */
export function plainFields(schema: Json, document: Json, path: string): Field[] {
  return fieldsAt(schema, document, path).filter((field) => field.kind !== 'other');
}

function kindOf(node: Json): FieldKind {
  if ('const' in node) return 'other';
  if (node.enum) return 'choice';
  if (node.type === 'number' || node.type === 'integer') return 'number';
  if (node.type === 'boolean') return 'yes';
  if (node.type !== 'string') return 'other';
  return node.pattern?.startsWith('^#') ? 'colour' : 'text';
}

function fieldOf(key: string, node: Json, required: boolean): Field {
  const about = (node.description ?? '') as string;
  const field: Field = {
    key, label: labelOf(key), help: '', kind: kindOf(node), whole: node.type === 'integer',
    min: node.minimum ?? -Infinity, max: node.maximum ?? Infinity, unit: unitOf(about), default: node.default,
    choices: (node.enum ?? []) as string[], required,
  };
  field.help = helpOf(field, about);
  return field;
}

/** A key as people read it: `drop_off` is "Drop off". */
export function labelOf(key: string): string {
  const words = key.replaceAll('_', ' ').replace(/ ([rst])$/, ' along $1');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/* Descriptions end with their unit in brackets; those that have a short sign are shown at the number. */
const signs: { [unit: string]: string } = {
  degree: '°', degrees: '°', pixel: 'px', stop: 'EV', s: 's', MiB: 'MiB',
};

function unitOf(about: string): string { return signs[/\(([^()]*)\)$/.exec(about)?.[1] ?? ''] ?? ''; }

function helpOf(field: Field, about: string): string {
  const sentence = about.charAt(0).toUpperCase() + about.slice(1);
  const parts = [sentence.endsWith('.') ? sentence : `${sentence}.`];
  if (field.kind === 'number' && Math.abs(field.max) < 1e9
    && Math.abs(field.min) < 1e9) parts.push(`${field.min} to ${field.max}.`);
  if (field.default !== undefined && field.kind !== 'other') parts.push(`Default: ${wordOf(field.default)}.`);
  return parts.join(' ');
}

function wordOf(value: unknown): string { return value === true ? 'yes' : value === false ? 'no' : String(value); }
