// Makes the pictures of docs/editor.md again: node bench/pictures.mjs FOLDER. The page is driven as in the tests.
import { execFileSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { closeBrowser, drag, drawn, join, openPage, program, readDocument, rmSync, settled, startServer, viewBox, workFolder, writeFileSync } from '../test/harness.mjs';

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

/* The kiwi cut along its axis and across it, as pictures to draw over: `wide` model units of each. */
function cutKiwi(name, normal, up, wide) {
  const path = join(folder, 'examples', `kiwi_${name}.pith`), text = readDocument(join(folder, 'examples', 'kiwi.pith')), away = 60;
  text.cuts = [{ plane: { point: normal.map((x) => -0.001 * x), normal }, keep: 'negative' }];
  text.camera = { eye: normal.map((x) => away * x), target: [0, 0, 0], up, field_of_view: (360 / Math.PI) * Math.atan(wide / 2 / away) };
  text.render = { width: 700, height: 700, samples: 16, background_red: 0.9, background_green: 0.9, background_blue: 0.88 };
  writeFileSync(path, JSON.stringify(text));
  execFileSync(program, ['render', path, '-o', join(folder, 'examples', `${name}.png`)]);
  return { image: `${name}.png`, width: wide };
}

/* The same kiwi, sketched over them. */
function sketchKiwi(text) {
  const round = (points) => points.map((point) => point.map((x) => Number(x.toFixed(3)) + 0));
  const profile = (r, z) => round(Array.from({ length: 11 }, (_, i) => [i % 10 === 0 ? 0 : r * Math.sin((Math.PI * i) / 10), z * Math.cos((Math.PI * i) / 10)]));
  const loop = (count, radius) => round(Array.from({ length: count }, (_, i) => {
    const turn = (2 * Math.PI * i) / count, r = radius(turn, i);
    return [r * Math.cos(turn), r * Math.sin(turn)];
  }));
  const oval = (r, less) => loop(20, (turn) => r * (1 - less * (1 - Math.cos(2 * turn))));
  const seed = (half) => round(Array.from({ length: 8 }, (_, i) => [0.03 * Math.cos((Math.PI * i) / 4), half * Math.sin((Math.PI * i) / 4)]));
  const around = (name, vertical, horizontal, front, back, blur) => ({ name, kind: 'around', vertical, horizontal, colours: { front, back, blur } });
  text.title = 'Kiwi, sketched';
  text.camera = { direction: [0.25, -1, 0.75] };
  text.sketch = { vertical: cutKiwi('along', [0, -1, 0], [0, 0, 1], 3.04), horizontal: cutKiwi('across', [0, 0, 1], [0, 1, 0], 2.42) };
  text.surfaces = [
    around('skin', profile(1, 1.25), oval(1, 0.025), '#6d5134', '#7c9c2a', 0),
    around('flesh', profile(0.62, 0.86), loop(18, (_, i) => 0.62 * (1 + 0.05 * (-1) ** i)), '#86ab2c', '#a9c24a', 0.04),
    around('core', profile(0.27, 0.66), oval(0.27, 0.02), '#dfe3ad', '#f1eed2', 0.03),
    { name: 'seeds', kind: 'grains', on: 'flesh', radius: 0.19, scale_spread: 0.2, offset: -0.06, grain: { profile: seed(0.075), outline: seed(0.045) },
      region: [{ points: [[0.45, 0, 0.55], [0.62, 0, 0], [0.45, 0, -0.55]], radius: 0.12, repeat: 'around' }], colours: { front: '#2a2018' } },
  ];
  text.cuts = [{ plane: { point: [0, 0, 0.1], normal: [0.25, -1, 0.75] }, keep: 'negative' }];
}

try {
  const sketch = await open('sketch.pith', sketchKiwi, { width: 1320, height: 800 });
  await use(sketch.page, { sketching: true, selectedSurface: 'flesh' });
  await sketch.page.locator('[data-key="sketch edit"]').click();
  await sketch.page.waitForFunction(() => Object.values(globalThis.pith.sketch.session.pictures).every((picture) => picture.image));
  await sketch.page.evaluate(() => Object.values(globalThis.pith.sketch.panes).forEach((pane) => pane.frame()));
  await sketch.page.mouse.move(660, 790);
  await sketch.page.waitForFunction(() => globalThis.pith.viewport.fine, undefined, { timeout: 120000 });
  await take(sketch.page, 'sketch');
  await sketch.end();

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
