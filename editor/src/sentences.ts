// What the server says, for people. Its sentences begin with the key of the request that is at fault, for those who
// write requests themselves; a person at the page wrote none.

const rules: [pattern: RegExp, said: string][] = [
  [/^there is nothing to undo\b.*$/i, 'There is nothing to undo.'],
  [/^there is nothing to do again\b.*$/i, 'There is nothing to redo.'],
  [/^job: no job .*$/, 'That had ended already.'],
  [/^(?:file|name): there is a file (.+?) already\b.*$/, 'There is a file $1 already.'],
  [/^(file|name): (is|has) /, 'The $1 $2 '],
  [/^(?:exemplar|path|operations?|revision|file|name): /, ''],
];

/** A refusal's sentence as the page shows it; `status` says of which kind it is. */
export function sentence(message: string, status = ''): string {
  if (status === 'stale') return 'Another page changed the document first; it is shown now.';
  const said = rules.reduce((text, [pattern, better]) => text.replace(pattern, better), message.trim());
  // Only a word begins with a capital; names of files and places of the document stay as they are.
  const begun = /^[a-z]+[ ,;’']/.test(said) ? said.charAt(0).toUpperCase() + said.slice(1) : said;
  return /[.!?…]$/.test(begun) ? begun : `${begun}.`;
}
