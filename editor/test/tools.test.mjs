// What tools make of drags and clicks: the operations they ask for. The model is an ellipsoid of half axes 1, 1, 1.25
// about the origin, whole, on a server that builds nothing.
import assert from 'node:assert/strict';
import { after, afterEach, describe, test } from 'node:test';
import { click, closeBrowser, drag, viewBox } from './harness.mjs';
import { applied, choose, eventually, example, openFake, settle } from './page.mjs';

let opened;

async function open(name = 'kiwi', tool, values = {}) {
  opened = await openFake(example(name, (document) => { document.cuts = []; document.camera = { direction: [0, -1, 0], up: [0, 0, 1], field_of_view: 24 }; }));
  const { page } = opened;
  await choose(page, { tool, ...values });
  const { width, height } = await viewBox(page);
  return { ...opened, at: (u, v) => [width * (0.5 + u), height * (0.5 + v)] };
}

const operations = (fake) => applied(fake).flatMap((step) => step.operations);
/* How far a point is from the ellipsoid scaled by `size`, 0 on it. */
const off = ([x, y, z], size = 1) => Math.abs(Math.hypot(x, y, z / 1.25) - size);
const onSkin = (points, size) => points.forEach((point) => assert.ok(off(point, size) < 0.02, `${point} is ${off(point, size)} away from the surface`));

describe('tools', { timeout: 600000 }, () => {
  afterEach(async () => {
    const { problems = [] } = opened ?? {};
    await opened?.close();
    opened = undefined;
    assert.deepEqual(problems, [], 'the browser complained');
  });
  after(closeBrowser);

  test('a fill asks for the face under the pointer, with depth and crease, and shows at once what it reaches', async () => {
    const { page, fake, at } = await open('kiwi', 'fill', { paint: 0.75, crease: 25 });
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.mode), 'shape', 'paint is seen on clay');
    await click(page, ...at(0, 0));
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, face, depth, crease }] = operations(fake);
    assert.deepEqual([op, depth, crease], ['depth.fill', 0.75, 25]);
    const shown = await page.evaluate((face) => {
      const { painted, triangles, positions } = globalThis.pith.viewport.meshes.get(0);
      const corner = (k) => positions.slice(3 * triangles[3 * face + k], 3 * triangles[3 * face + k] + 3);
      return { count: painted.filter((each) => each === 0.75).length, all: painted.length, y: corner(0)[1] };
    }, face);
    assert.ok(shown.y < -0.9, 'the face looks at the eye');
    assert.equal(shown.count, shown.all, 'nothing of the round skin bends by 25 degrees');
    await choose(page, { tool: 'select' });
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.mode), 'solid', 'the view is as it was');
  });

  test('paint that was refused is taken off again', async () => {
    const { page, fake, at } = await open('kiwi', 'fill', { paint: 0.5 });
    fake.revision += 1;
    await click(page, ...at(0, 0));
    await page.getByText('Another page changed the document first; it is shown now.').waitFor();
    assert.equal(await page.evaluate(() => globalThis.pith.viewport.meshes.get(0).painted.filter((each) => each === 0.5).length), 0);
  });

  test('single faces are painted along a drag, each once; wiping asks for the same faces', async () => {
    const { page, fake, at } = await open('kiwi', 'face', { paint: 1 });
    await drag(page, [at(-0.15, 0), at(0.15, 0.02)], { steps: 3 });
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, faces, depth }] = operations(fake);
    assert.deepEqual([op, depth], ['depth.face', 1]);
    assert.equal(new Set(faces).size, faces.length);
    // 0.3 of the view's width across a ball of 36 columns is about ten of them: a quick drag leaves no gaps.
    assert.ok(faces.length >= 8, `only ${faces.length} faces`);
    await choose(page, { erase: true });
    await click(page, ...at(0, 0));
    await eventually('it was wiped', () => operations(fake).length === 2);
    assert.equal(operations(fake)[1].op, 'depth.erase');
    assert.equal(operations(fake)[1].faces.length, 1);
  });

  test('a depth stroke lies on the skin, thinned; a click draws nothing', async () => {
    const { page, fake, at } = await open('kiwi', 'depth', { paint: 0.25 });
    await click(page, ...at(0, 0));
    await drag(page, [at(-0.15, -0.1), at(0, 0.05), at(0.15, -0.1)], { steps: 12 });
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, points, depth }] = operations(fake);
    assert.deepEqual([op, depth], ['depth.stroke', 0.25]);
    onSkin(points);
    assert.ok(points.length >= 3 && points.length < 24, `${points.length} points`);
    assert.ok(points[0][0] < -0.3 && points.at(-1)[0] > 0.3, 'from left to right');
  });

  test('Escape gives up a stroke', async () => {
    const { page, fake, at } = await open('kiwi', 'depth');
    const box = await viewBox(page), [[x, y], [u, v]] = [at(-0.1, 0), at(0.1, 0)];
    await page.mouse.move(box.x + x, box.y + y);
    await page.mouse.down();
    await page.mouse.move(box.x + u, box.y + v, { steps: 6 });
    await page.keyboard.press('Escape');
    await page.mouse.up();
    await settle(page);
    assert.equal(applied(fake).length, 0);
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'depth', 'the tool is still there');
    await page.keyboard.press('Escape');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'select');
  });

  test('points go where the button is let go', async () => {
    const { page, fake, at } = await open('kiwi', 'points', { paint: 0.5 });
    await drag(page, [at(-0.1, 0), at(0.1, 0.05)]);
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, points, depth }] = operations(fake);
    assert.deepEqual([op, depth, points.length], ['depth.points', 0.5, 1]);
    onSkin(points);
    assert.ok(points[0][0] > 0.2 && points[0][2] < 0);
  });

  test('directions are drawn on the layer that is looked at; Alt and the wheel go through the layers', async () => {
    const { page, fake, at } = await open('kiwi', 'direction', { layer: 0.4 });
    await eventually('the layer is shown', () => fake.asked.some((request) => request.do === 'layer' && request.depth === 0.4));
    await settle(page);
    await drag(page, [at(0, 0.12), at(0.02, -0.12)], { steps: 10 });
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, points }] = operations(fake);
    assert.equal(op, 'direction.stroke');
    onSkin(points, 0.6);
    assert.ok(points.at(-1)[2] > points[0][2], 'upwards');
    const box = await viewBox(page);
    await page.mouse.move(box.x + at(0, 0)[0], box.y + at(0, 0)[1]);
    await page.keyboard.down('Alt');
    await page.mouse.wheel(0, 100);
    await page.keyboard.up('Alt');
    await eventually('it went deeper', async () => (await page.evaluate(() => globalThis.pith.store.state.layer)) === 0.42);
    await page.keyboard.press(']');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.layer), 0.37);
    await page.keyboard.press('\\');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.layer), null);
  });

  test('type 0-B draws vectors instead, on the skin', async () => {
    const { page, fake, at } = await open('muscle', 'direction');
    await drag(page, [at(0, 0.1), at(0, -0.1)], { steps: 8 });
    await eventually('it was asked for', () => operations(fake).length === 1);
    assert.equal(operations(fake)[0].op, 'vectors.surface');
    onSkin(operations(fake)[0].points);
  });

  test('a size is chosen with the wheel and set with a double click', async () => {
    const { page, fake, at } = await open('sponge', 'scale', { size: 0.5 });
    await eventually('the exemplar is here', () => fake.asked.some((request) => request.do === 'exemplar'));
    await click(page, ...at(0.05, 0));
    assert.equal(await page.evaluate(() => globalThis.pith.viewport.ghosting), true);
    const distance = () => page.evaluate(() => globalThis.pith.viewport.table.camera.position.length()), before = await distance();
    await page.mouse.wheel(0, -300);
    await eventually('it is larger', async () => (await page.evaluate(() => globalThis.pith.store.state.size)) > 0.55);
    assert.equal(await distance(), before, 'the wheel did not zoom');
    const box = await viewBox(page), [x, y] = at(0.1, 0);
    await page.mouse.dblclick(box.x + x, box.y + y);
    await eventually('it was asked for', () => operations(fake).length === 1);
    const [{ op, point, size }] = operations(fake);
    assert.equal(op, 'scale.point');
    onSkin([point]);
    assert.equal(size, await page.evaluate(() => globalThis.pith.store.state.size));
    await choose(page, { tool: 'select' });
    assert.equal(await page.evaluate(() => globalThis.pith.viewport.ghosting), false);
  });

  test('a paste is moved, turned, and set with a double click', async () => {
    const { page, fake, at } = await open('kiwi', 'paste', { size: 0.4, pasting: { recipe: 'exemplars/cherry.json' } });
    await eventually('the exemplar is here', () => fake.asked.some((request) => request.do === 'exemplar'));
    const along = () => page.evaluate(() => { const part = globalThis.pith.viewport.view.parts[0]; return part.mesh.material.uniforms.ghostMatrix.value.elements.slice(); });
    await drag(page, [at(-0.1, 0), at(0, 0)]);
    const before = await along();
    await drag(page, [at(0, 0), at(0.1, 0)], { keys: ['Shift'] });
    const after = await along();
    assert.ok(before.some((x, i) => Math.abs(x - after[i]) > 0.1), 'it turned');
    const box = await viewBox(page), [x, y] = at(0, 0);
    await page.mouse.dblclick(box.x + x, box.y + y);
    await eventually('it was asked for', () => operations(fake).length === 1);
    const { op, exemplar, point, up, along: t, size } = operations(fake)[0];
    assert.deepEqual([op, exemplar, size], ['paste.add', { recipe: 'exemplars/cherry.json' }, 0.4]);
    onSkin([point]);
    // Its depth axis goes in where it stands, its other axis lies across.
    assert.ok(up[1] > 0.95, `up is ${up}`);
    assert.ok(Math.abs(up[0] * t[0] + up[1] * t[1] + up[2] * t[2]) < 1e-5);
  });

  test('the gap of cuts that keep both sides is that of the uncut model, however far its pieces lie apart', async () => {
    const { page, fake, at } = await open('kiwi', 'cut', { keep: 'both' });
    await page.evaluate(() => globalThis.pith.actions.apply('Cut', [{ op: 'cut.plane', plane: { point: [0, 0, 0], normal: [0, 0, 1] }, keep: 'both', gap: 40 }]));
    await settle(page);
    await drag(page, [at(0, -0.4), at(0.02, 0.4)], { steps: 12 });
    await eventually('the cut was asked for', () => applied(fake).length === 2);
    const diagonal = Math.hypot(2, 2, 2.5);
    const little = (gap) => assert.ok(Math.abs(gap - 0.12 * diagonal) < 0.002 * diagonal, `a gap of ${gap} in a model of ${diagonal}`);
    little(operations(fake)[1].gap);
    await choose(page, { tool: 'plane' });
    await page.getByText('Cut, keep both').click();
    await eventually('the plane was asked for', () => applied(fake).length === 3);
    little(operations(fake)[2].gap);
  });

  test('the clip plane stays within the model, and is in its middle again when what it stood in is gone', async () => {
    const { page, fake } = await open('kiwi', 'plane');
    const along = () => fake.asked.findLast((request) => request.do === 'section').plane.point[1];
    const wheel = async (delta, count) => { for (let i = 0; i < count; ++i) await page.mouse.wheel(0, delta); await settle(page); };
    const box = await viewBox(page);
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.keyboard.down('Shift');
    await wheel(-100, 150);
    const near = along();
    assert.ok(Math.abs(near) > 0.9 && Math.abs(near) < 1, `held at ${near} of 1`);
    await wheel(100, 300);
    assert.ok(Math.abs(along() + near) < 1e-6, `${near} and ${along()} are as far from the middle`);
    await page.keyboard.up('Shift');
    await choose(page, { tool: 'select' });
    // The model is another one meanwhile, further on.
    await page.evaluate(() => { const { together } = globalThis.pith.viewport.view; together.min.y += 10; together.max.y += 10; });
    await choose(page, { tool: 'plane' });
    await eventually('it is in the middle', () => Math.abs(along() - 10) < 1e-6);
  });

  test('Enter cuts after a button of the clip plane, and the volume view gives way to it', async () => {
    const { page, fake } = await open('kiwi', 'select', { mode: 'volume' });
    await choose(page, { tool: 'plane' });
    const mode = () => page.evaluate(() => globalThis.pith.store.state.mode);
    assert.equal(await mode(), 'solid');
    await page.locator('.tool-options').getByText('X', { exact: true }).click();
    await page.keyboard.press('Enter');
    await eventually('it was cut', () => operations(fake).length === 1);
    const { op, plane, keep } = operations(fake)[0];
    assert.deepEqual([op, plane.normal.map(Math.abs), keep], ['cut.plane', [1, 0, 0], 'negative']);
    await eventually('the volume is back', async () => await mode() === 'volume');
    await choose(page, { tool: 'plane' });
    await choose(page, { mode: 'volume' });
    await page.locator('.message', { hasText: 'does not show the clip plane' }).waitFor();
  });

  test('the row of a stroke marks it in the view', async () => {
    const { page } = await open('kiwi', 'select', { tab: 'fields' });
    const widths = () => page.evaluate(() => globalThis.pith.viewport.overlay.lists.get('document').map((mark) => mark.width));
    const plain = await widths();
    await page.locator('[data-section=direction] .list-row').hover();
    await eventually('it is marked', async () => (await widths()).some((width, i) => width > plain[i]));
  });
});
