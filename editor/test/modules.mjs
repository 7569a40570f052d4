// Single modules of the page for tests without a browser: bundled on the spot, then imported.
import { build } from 'esbuild';
import { mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const source = join(dirname(fileURLToPath(import.meta.url)), '..', 'src');

/** Imports a module of src/ by its name, `fields` or `ui/numbers`. */
export async function load(name) {
  const out = join(mkdtempSync(join(tmpdir(), 'pith-module-')), 'module.mjs');
  await build({ entryPoints: [join(source, `${name}.ts`)], outfile: out, bundle: true, format: 'esm', platform: 'neutral', logLevel: 'warning',
                mainFields: ['module', 'main'], loader: { '.glsl': 'text', '.pith': 'json' } });
  return import(pathToFileURL(out));
}
