// Builds the page: node build.mjs FOLDER. Bundles src/main.ts and src/style.css, copies index.html and assets/, and puts
// a gzip copy beside every file, which the server sends as it is.
import { build } from 'esbuild';
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, '..', 'build', 'editor');

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
await build({
  entryPoints: { editor: join(here, 'src', 'main.ts'), style: join(here, 'src', 'style.css') },
  outdir: out, bundle: true, minify: true, format: 'esm', target: 'es2022', legalComments: 'none', logLevel: 'warning',
  loader: { '.glsl': 'text', '.svg': 'text', '.pith': 'json' },
});
cpSync(join(here, 'index.html'), join(out, 'index.html'));
cpSync(join(here, 'assets'), out, { recursive: true });

let total = 0;
for (const name of readdirSync(out)) {
  const path = join(out, name);
  if (!statSync(path).isFile()) continue;
  const bytes = gzipSync(readFileSync(path), { level: 9 });
  writeFileSync(path + '.gz', bytes);
  total += bytes.length;
}
console.log(`editor: ${(total / 1000).toFixed(0)} kB compressed`);
