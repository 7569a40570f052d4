// Makes the pictures of docs/editor.md again: node bench/pictures.mjs FOLDER. The page is driven as in the tests.
import { mkdirSync } from 'node:fs';
import { closeBrowser, drag, drawn, join, openPage, readDocument, rmSync, settled, startServer, viewBox, workFolder, writeFileSync } from '../test/harness.mjs';

const out = process.argv[2] ?? 'docs/editor';
mkdirSync(out, { recursive: true });
const folder = workFolder();

async function open(name, change = () => {}, options = {}) {
  const path = join(folder, 'examples', name), text = readDocument(path);
  change(text);
  writeFileSync(path, JSON.stringify(text));
  const server = await startServer(path);
  const opened = await openPage(server, { width: 1200, height: 750, ...options });
  return { ...opened, async end() { await opened.close(); await server.stop(); } };
}

/* In software the view is drawn finely when it has come to rest. */
async function take(page, name) {
  await drawn(page);
  await page.waitForTimeout(900);
  await page.evaluate(() => globalThis.pith.viewport.picture());
  await drawn(page);
  await page.screenshot({ path: join(out, `${name}.png`) });
  console.log(name);
}
const use = (page, values) => page.evaluate((values) => globalThis.pith.store.set(values), values);

try {
  const kiwi = await open('kiwi.pith', (text) => { text.camera = { direction: [0.9, -1, 0.75] }; });
  await take(kiwi.page, 'cut');
  await use(kiwi.page, { mode: 'depth', tool: 'fill' });
  await take(kiwi.page, 'depth');
  await use(kiwi.page, { tool: 'direction', mode: 'depth', layer: 0.35, lines: 'layer' });
  await kiwi.page.evaluate(() => globalThis.pith.viewport.table.zoom(1.4)); // a layer is whole, whatever is cut away
  await kiwi.page.waitForTimeout(2500);
  await take(kiwi.page, 'lines');
  await kiwi.end();

  const whole = await open('kiwi.pith', (text) => { delete text.cuts; text.camera = { direction: [0.9, -1, 0.45] }; });
  await use(whole.page, { tool: 'plane' });
  await whole.page.waitForTimeout(2500);
  const { width, height } = await viewBox(whole.page);
  await drag(whole.page, [[width * 0.5, height * 0.5], [width * 0.53, height * 0.46]], { steps: 3 });
  await whole.page.waitForTimeout(2500);
  await take(whole.page, 'plane');
  await whole.end();

  const bunny = await open('kiwi_bunny.pith', (text) => { text.cuts[0].gap = 2.5; }, { theme: 'light' });
  await settled(bunny.page);
  await take(bunny.page, 'bunny');
  await bunny.end();

  const wood = await open('wood.pith', undefined, { width: 960, height: 620 });
  await wood.page.locator('[data-key="node rings"]').click();
  await wood.page.locator('.inspector-scroll').evaluate((panel) => { panel.scrollTop = 280; });
  await wood.page.waitForFunction(() => globalThis.pith.viewport.fine && globalThis.pith.asked.whole > 0);
  await take(wood.page, 'graph');
  await wood.end();
} finally {
  await closeBrowser();
  rmSync(folder, { recursive: true, force: true });
}
