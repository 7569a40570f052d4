// Surfaces that colours flow from, in three dimensions: the real program, a real browser. The surface worked on is a tube
// of radius 1/2 about the z axis, from -0.4 to 0.4, red outside and green inside, in a fruit of radius 1.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { click, Desk, drag, drawn, join, pixels, settled, state, viewBox, writeFileSync } from './harness.mjs';
import { load } from './modules.mjs';

const red = '#d02010', green = '#10b030', blue = '#1030e0';
const tube = { name: 'tube', kind: 'around', vertical: [[0.5, 0.4], [0.5, 0.1], [0.5, -0.4]], across: 64, along: 17, colours: { front: red, back: green } };
const fruit = (more = {}) => ({
  pith: 1, title: 'tube', camera: { direction: [0, -1, 0], up: [0, 0, 1], field_of_view: 24 },
  shape: { fruit: { detail: 3 }, tets: { tetrahedra: 300 } }, surfaces: [tube], ...more,
});

let desk;

async function open(document = fruit(), { built = false } = {}) {
  const path = join(desk.folder, 'tube.pith');
  writeFileSync(path, JSON.stringify(document));
  const page = await desk.open(path, { built });
  await page.waitForFunction(() => globalThis.pith.viewport.surfaces.shown.length > 0 && globalThis.pith.viewport.view, undefined, { timeout: 60000, polling: 30 });
  await page.waitForFunction(() => !globalThis.pith.store.state.jobs.some((job) => job.state === 'waiting' || job.state === 'running'), undefined, { timeout: 60000, polling: 50 });
  const { width, height } = await viewBox(page);
  return { page, at: (u, v) => [width * (0.5 + u), height * (0.5 + v)] };
}

const use = async (page, values) => { await page.evaluate((values) => globalThis.pith.store.set(values), values); await drawn(page); };
const lastSurface = async (page) => (await state(page)).document.surfaces.at(-1);
/* Which channel of a pixel is greatest; '' where nothing is drawn. */
const hue = ([r, g, b, a]) => (a < 8 ? '' : r > g && r > b ? 'red' : g > b ? 'green' : 'blue');

/* Until the page has what the document says. */
async function caught(page, revision) {
  await page.waitForFunction((revision) => globalThis.pith.store.state.revision >= revision && globalThis.pith.viewport.surfaces.revision >= revision,
    revision, { timeout: 30000, polling: 20 });
  await drawn(page);
}

/* What is shown of a surface, and what the server said of it. */
const look = (page, name = 'tube') => page.evaluate((name) => {
  const surface = globalThis.pith.viewport.surfaces.find(globalThis.pith.store.state.body, name);
  const bytes = (from) => [...from];
  const shown = (which) => bytes(surface.mesh.geometry.getAttribute(which).array);
  return { key: surface.key, positions: bytes(surface.positions), drawn: bytes(surface.drawn), triangles: surface.triangles.length / 3,
    front: bytes(surface.front), back: bytes(surface.back), blur: bytes(surface.blur), shownFront: shown('front'), shownBack: shown('back'), value: shown('value') };
}, name);
const coloured = (bytes, colour) => {
  const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)), found = [];
  for (let v = 0; 4 * v < bytes.length; ++v) if (wanted.every((each, c) => bytes[4 * v + c] === each)) found.push(v);
  return found;
};
const near = (a, b, tolerance, what) => assert.ok(Math.abs(a - b) <= tolerance, `${what}: ${a} is not within ${tolerance} of ${b}`);

test('a brush meets what lies within its radius of what was drawn, and of its copies', async () => {
  const { meetVertices } = await load('brush'), drawnPoints = [];
  for (let i = 0; i < 12; ++i) drawnPoints.push(Math.cos((i * Math.PI) / 6), Math.sin((i * Math.PI) / 6), 0);
  const meet = (from, to, how) => { const met = []; const count = meetVertices(drawnPoints, from, to, { radius: 0.1, repeat: 'once', folds: 0, ...how }, (v) => met.push(v)); assert.equal(count, met.length); return met; };
  assert.deepEqual(meet([1, 0, 0], [1, 0, 0]), [0]);
  assert.deepEqual(meet([1, 0, 0.2], [1, 0, 0.11]), [], 'beyond the end of the stroke');
  assert.deepEqual(meet([1, 0, 0.2], [1, 0, 0.09]), [0]);
  assert.deepEqual(meet([1, 0, 0], [0, 1, 0], { radius: 0.3 }), [0, 1, 2, 3], 'between its points it is straight');
  assert.deepEqual(meet([1, 0, 0], [1, 0, 0], { repeat: 'folds', folds: 4 }).sort((a, b) => a - b), [0, 3, 6, 9]);
  assert.deepEqual(meet([1, 0, 0], [1, 0, 0], { repeat: 'folds' }), [0], 'without folds once');
  assert.equal(meet([0, -1, 0.05], [0, -1, 0.05], { repeat: 'around' }).length, 12);
});

test('sides of a stroke are those of cuts: right as it runs, on straight beyond its ends', async () => {
  const { sideOfStroke } = await load('brush'), up = [{ x: 0, y: 10 }, { x: 0, y: -10 }];
  assert.equal(sideOfStroke(up, 5, 0), 'right');
  assert.equal(sideOfStroke(up, -5, 0), 'left');
  assert.equal(sideOfStroke(up, 5, -100), 'right');
  assert.equal(sideOfStroke([...up].reverse(), 5, 0), 'left');
  const hook = [{ x: 0, y: 0 }, { x: 10, y: 0 }, { x: 10, y: 10 }]; // to the right, then down
  assert.equal(sideOfStroke(hook, 5, 5), 'right');
  assert.equal(sideOfStroke(hook, 14, -3), 'left', 'at the outside of the corner');
  assert.equal(sideOfStroke(hook, 12, 30), 'left');
});

describe('surfaces', { timeout: 600000 }, () => {
  desk = new Desk();

  test('each side has its colour, the skin about them is seen through, and eyes hide', async () => {
    const { page, at } = await open();
    await use(page, { mode: 'surfaces', skin: 0 });
    let [middle, beside] = await pixels(page, [at(0, 0), at(0.25, 0)]);
    assert.equal(hue(middle), 'red', 'the outside is turned to the eye');
    assert.equal(hue(beside), '', 'the skin is gone');
    await use(page, { skin: 0.5 });
    [middle, beside] = await pixels(page, [at(0, 0), at(0.25, 0)]);
    assert.equal(hue(middle), 'red', 'it is seen through the skin');
    assert.ok(beside[3] > 60 && beside[3] < 250, `the skin covers ${beside[3]} of 255`);
    await use(page, { skin: 0, shownSurfaces: { tube: false } });
    [middle] = await pixels(page, [at(0, 0)]);
    assert.equal(hue(middle), '', 'hidden');
    await use(page, { shownSurfaces: {} });
    await page.keyboard.press('7');
    await drawn(page);
    const { x } = await page.evaluate(() => {
      const { viewport } = globalThis.pith, at = viewport.table.target.clone().set(0.5, 0, 0).project(viewport.table.camera);
      return { x: at.x };
    });
    [middle] = await pixels(page, [at(0.5 * x, 0)]);
    assert.equal(hue(middle), 'green', 'from above the inside is turned to the eye');
    await use(page, { mode: 'solid' });
    [middle] = await pixels(page, [at(0, 0)]);
    assert.ok(Math.abs(middle[0] - middle[1]) < 30, 'the skin alone');
  });

  test('a drag paints: it shows at once, is one operation, and what the server makes of it has the same vertices', async () => {
    const rims = [0.4, -0.4].map((z) => ({ brush: { points: [[0.5, 0, z]], radius: 0.01, repeat: 'around' }, front: red, back: green }));
    const { page, at } = await open(fruit({ surfaces: [{ ...tube, paint: rims }] }));
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.08, paintSide: 'front' });
    assert.equal((await state(page)).mode, 'surfaces', 'it shows what is painted');
    const box = await viewBox(page), from = at(-0.06, 0), to = at(0.06, 0.03), before = await look(page);
    await page.mouse.move(box.x + from[0], box.y + from[1]);
    await page.mouse.down();
    await page.mouse.move(box.x + to[0], box.y + to[1], { steps: 3 });
    const during = await look(page), { revision } = await state(page), met = coloured(during.shownFront, blue);
    assert.equal(during.key, before.key, 'nothing was asked for yet');
    assert.ok(met.length > 10, `${met.length} vertices are blue`);
    assert.deepEqual(coloured(during.shownBack, blue), [], 'the back is as it was');
    await page.mouse.up();
    await caught(page, revision + 1);
    const done = await look(page), { paint } = await lastSurface(page), [{ brush, front, back }] = paint.slice(2);
    assert.equal(paint.length, 3, 'one operation');
    assert.deepEqual([front, back], [blue, undefined]);
    assert.equal(brush.radius, 0.08);
    for (const [x, y] of brush.points) near(Math.hypot(x, y), 0.5, 2e-3, 'on the tube');
    assert.ok(brush.points.every(([, y]) => y < 0), 'on the side that is seen');
    assert.deepEqual(coloured(done.front, blue), met, 'the same vertices');
    assert.ok(done.front.some((byte, i) => i % 4 === 2 && byte > 0x20 && byte < 0xd0), 'smoothed in between');
    assert.deepEqual(done.back, before.back);
    await page.keyboard.press('Control+z');
    await caught(page, revision + 2);
    assert.deepEqual((await look(page)).front, before.front, 'undone');
    await page.keyboard.press('Control+Shift+z');
    await caught(page, revision + 3);
    assert.deepEqual((await look(page)).front, done.front, 'and done again');
    assert.deepEqual((await state(page)).recentColours, [blue]);
  });

  test('paint all round the axis, and blur, are painted the same way', async () => {
    const { page, at } = await open();
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.06, paintRepeat: 'around' });
    let { revision } = await state(page);
    await drag(page, [at(-0.01, 0), at(0.01, 0)]);
    await caught(page, revision + 1);
    let { paint } = await lastSurface(page);
    assert.deepEqual([paint[0].brush.repeat, paint[0].front, paint[0].back], ['around', blue, blue]);
    await use(page, { paintWhat: 'blur', paintBlur: 0.03, paintRepeat: 'once' });
    ({ revision } = await state(page));
    await drag(page, [at(-0.02, 0), at(0.02, 0)]);
    await caught(page, revision + 1);
    ({ paint } = await lastSurface(page));
    assert.deepEqual(Object.keys(paint[1]).sort(), ['blur', 'brush']);
    assert.equal(paint[1].blur, 0.03);
    const { blur } = await look(page);
    blur.forEach((each) => near(each, 0.03, 1e-6, 'spread over all'));
  });

  test('a surface of one colour gets two when a side is painted; flipping exchanges them', async () => {
    const { page, at } = await open(fruit({ surfaces: [{ ...tube, colours: { front: red } }] }));
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.06, paintSide: 'both' });
    let { revision } = await state(page);
    await drag(page, [at(-0.02, -0.05), at(0.02, -0.05)]);
    await caught(page, revision + 1);
    assert.equal((await lastSurface(page)).paint[0].back, undefined, 'one colour stays one colour');
    await use(page, { paintSide: 'front', paintColour: green });
    ({ revision } = await state(page));
    await drag(page, [at(-0.02, 0.05), at(0.02, 0.05)]);
    await caught(page, revision + 1);
    const { colours, paint } = await lastSurface(page);
    assert.deepEqual(colours, { front: red, back: red });
    assert.deepEqual(paint.map(({ front, back }) => [front, back]), [[blue, blue], [green, undefined]]);
    const before = await look(page);
    assert.ok(coloured(before.front, green).length > 0);
    await page.locator('.tool-options [data-key="surface-flip"]').click();
    await caught(page, revision + 2);
    const after = await look(page);
    assert.deepEqual(after.front, before.back);
    assert.deepEqual(after.back, before.front);
  });

  test('paint that is refused is taken off again', async () => {
    const { page, at } = await open();
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.06 });
    const before = await look(page);
    await page.evaluate(() => { globalThis.pith.store.state.revision += 7; });
    await drag(page, [at(-0.02, 0), at(0.02, 0)]);
    await page.getByText('Another page changed the document first; it is shown now.').waitFor();
    await drawn(page);
    const after = await look(page);
    assert.deepEqual(after.shownFront, before.front);
    assert.equal((await lastSurface(page)).paint, undefined);
  });

  test('bodies that are placed are painted where their surfaces were drawn', async () => {
    const { page, at } = await open(fruit({ shape: { fruit: { detail: 3 }, tets: { tetrahedra: 300 }, place: { scale: 3, turn_z: 90, move_x: 5 } } }));
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.3 });
    const { revision } = await state(page);
    await drag(page, [at(-0.01, 0), at(0.01, 0)]);
    await caught(page, revision + 1);
    const { brush } = (await lastSurface(page)).paint[0];
    near(brush.radius, 0.1, 1e-3, 'the radius');
    for (const [x, y] of brush.points) near(Math.hypot(x, y), 0.5, 2e-3, 'on the tube');
    // What looks at the eye, along y, is what was drawn on the side of -x.
    assert.ok(brush.points.every(([x]) => x < -0.4), JSON.stringify(brush.points));
  });

  test('what is painted on a body like another is painted on all of them', async () => {
    const { shape, surfaces, camera } = fruit();
    const { page, at } = await open({ pith: 1, camera, bodies: [{ name: 'one', shape, surfaces },
      { name: 'other', like: 'one', shape: { place: { move_y: -4 } } }] });
    await use(page, { tool: 'paint-surface', paintColour: blue, paintRadius: 0.1 });
    const { revision } = await state(page);
    await drag(page, [at(-0.01, 0), at(0.01, 0)]);
    await caught(page, revision + 1);
    assert.equal((await state(page)).body, 1, 'the nearer one was met');
    const [{ surfaces: [painted] }, other] = (await state(page)).document.bodies;
    assert.equal(painted.paint.length, 1);
    assert.equal(other.surfaces, undefined);
    const all = await page.evaluate(() => globalThis.pith.viewport.surfaces.shown.map(({ front }) => [...front.slice(0, 3)]));
    assert.deepEqual(all, [[0x10, 0x30, 0xe0], [0x10, 0x30, 0xe0]]);
  });

  test('a stroke and a click take a part of a surface away', async () => {
    const { page, at } = await open();
    await use(page, { tool: 'erase-surface', selectedSurface: 'tube' });
    const before = await look(page);
    let { revision } = await state(page);
    await drag(page, [at(0.02, 0.3), at(0.02, -0.3)]); // upwards, right of the axis: x about 0.08
    assert.equal((await state(page)).revision, revision, 'it waits for the click');
    const box = await viewBox(page), [u, v] = at(0.08, 0.05);
    await page.mouse.move(box.x + u, box.y + v);
    await page.waitForFunction(() => globalThis.pith.viewport.surfaces.find(0, 'tube').mesh.geometry.getAttribute('value').array.some((each, i) => i % 2 === 1 && each === 1));
    await page.keyboard.press('Escape');
    assert.deepEqual([(await state(page)).tool, (await state(page)).revision], ['erase-surface', revision], 'Escape keeps all');
    await drag(page, [at(0.02, 0.3), at(0.02, -0.3)]);
    await click(page, u, v);
    await caught(page, revision + 1);
    const { erase } = await lastSurface(page), half = await look(page);
    assert.equal(erase.length, 1);
    assert.equal(erase[0].side, 'positive', 'right of the stroke');
    assert.ok(half.triangles < before.triangles);
    const edge = Math.max(...half.positions.filter((_, i) => i % 3 === 0));
    assert.ok(edge > 0 && edge < 0.2, `what is left ends at x = ${edge}`);
    near(Math.min(...half.positions.filter((_, i) => i % 3 === 0)), -0.5, 1e-3, 'the other half is whole');
    await page.keyboard.press('Control+z');
    await caught(page, revision + 2);
    assert.equal((await look(page)).triangles, before.triangles);
    await use(page, { eraseSide: 'left' });
    ({ revision } = await state(page));
    await drag(page, [at(0.02, 0.3), at(0.02, -0.3)]);
    await caught(page, revision + 1);
    assert.ok(Math.min(...(await look(page)).positions.filter((_, i) => i % 3 === 0)) > 0, 'left of the stroke');
  });

  test('the section of flowing colours is asked for when the view rests, and hidden surfaces still colour it', async () => {
    const { page, at } = await open({
      pith: 1, title: 'ball', camera: { direction: [0.01, -1, 0.6], up: [0, 0, 1], field_of_view: 24 },
      shape: { fruit: { detail: 3 }, tets: { tetrahedra: 300 } }, cuts: [{ plane: { point: [0, 0, 0], normal: [0, 0, 1] }, keep: 'negative' }],
      surfaces: [{ name: 'skin', kind: 'body', colours: { front: blue, back: green } }], solids: [{ name: 'inside', kind: 'diffusion', rays: 32 }],
    }, { built: true });
    await page.waitForFunction(() => globalThis.pith.viewport.view.kinds.includes(1) && globalThis.pith.viewport.view.skinned.has(0), undefined, { timeout: 60000, polling: 50 });
    await settled(page);
    let [section, skin] = await pixels(page, [at(0, -0.05), at(0, 0.3)]);
    assert.deepEqual([hue(section), hue(skin)], ['green', 'blue'], 'the skin has the colour of its outside while voxels are shown');
    await page.waitForFunction(() => globalThis.pith.viewport.fine, undefined, { timeout: 120000, polling: 50 });
    [section, skin] = await pixels(page, [at(0, -0.05), at(0, 0.3)]);
    assert.deepEqual([hue(section), hue(skin)], ['green', 'blue']);
  });
});
