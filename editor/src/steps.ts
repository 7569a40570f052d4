// What a list of operations would do to the document, asked before it becomes a step that can be undone.

import type { Json, Point } from './protocol';
import { valueAt } from './schema';

interface PartEntry { hidden?: boolean; offset?: Point }
const partEntries = (document: Json): PartEntry[] => (document.parts ?? []) as PartEntry[];

/** Is a part hidden? */
export function anyHidden(document: Json): boolean { return partEntries(document).some((part) => part.hidden); }

/** Has a part been moved by hand? */
export function anyMoved(document: Json): boolean {
  return partEntries(document).some((part) => part.offset?.some((x) => x !== 0));
}

/** Would the operations leave the document as it is? Only what is plain to see counts: values that are there already,
    values that are not there, parts that are neither hidden nor moved. */
export function changesNothing(document: Json, operations: Json[]): boolean {
  return operations.every(({ op, path, value, all }) => {
    switch (op) {
      case 'set': return JSON.stringify(valueAt(document, path)) === JSON.stringify(value);
      case 'remove': return valueAt(document, path) === undefined;
      case 'part.show': return all === true && !anyHidden(document);
      case 'part.together': return !anyMoved(document);
      default: return false;
    }
  });
}
