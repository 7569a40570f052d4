// Computed solids in the editor: the graph as a list of functions, its changes as the document has them afterwards, and
// pixels against what the command line says of the same points.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { describe, test } from 'node:test';
import { Desk, drawn, pixels, program, readDocument, settled, state } from './harness.mjs';
import { load } from './modules.mjs';
import { eventually } from './page.mjs';

const point = (name = 'at') => ({ name, takes: 'point', wanted: false, many: false, standard: 0 });
const number = (name, wanted = true) => ({ name, takes: 'number', wanted, many: false, standard: 0.5 });
const functions = {
  position: { gives: 'point', inputs: [] }, place: { gives: 'point', inputs: [point()] },
  noise: { gives: 'number', inputs: [point()] }, rings: { gives: 'number', inputs: [point()] },
  curve: { gives: 'number', inputs: [number('of')] }, map: { gives: 'colour', inputs: [number('by')] },
  combine: { gives: 'number', inputs: [{ name: 'of', takes: 'any', wanted: true, many: true, standard: 0 }] },
  dot: { gives: 'number', inputs: [{ ...point('a'), wanted: true }, { ...point('b'), wanted: true }] },
};
const schema = { $defs: {
  function_noise: { properties: { size: { minimum: 0.1, maximum: 10 }, seed: { minimum: 0, maximum: 9 } } },
  function_rings: { properties: { size: { minimum: 0.5, maximum: 2 }, late: {} } }, function_map: { required: ['stops'], properties: { stops: {} } },
  function_curve: { properties: {} }, function_dot: { properties: {} },
} };
const sample = () => ({ name: 'x', kind: 'procedural', colour: 'look', opacity: 'sum', nodes: [
  { name: 'look', function: 'map', by: 'sum', stops: [] }, { name: 'sum', function: 'combine', of: ['a', 0.5, 'b', 'a'] },
  { name: 'a', function: 'noise', at: 'stand', size: 4, seed: 3 }, { name: 'b', function: 'curve', of: 'a' },
  { name: 'stand', function: 'place' }, { name: 'tint', function: 'combine', of: ['look', 0.5] },
] });

describe('graphs', () => {
  test('each node comes after those it takes from; what no output is made of is told', async () => {
    const { Graph } = await load('graph'), graph = new Graph(sample(), functions);
    assert.deepEqual(graph.order().map(({ name }) => name), ['stand', 'a', 'b', 'sum', 'look', 'tint']);
    assert.deepEqual([...graph.needed()].sort(), ['a', 'b', 'look', 'stand', 'sum']);
    assert.equal(graph.gives(graph.nodes[1]), 'number');
    assert.equal(graph.gives(graph.nodes[5]), 'colour', 'a sum of colours is one');
    assert.deepEqual(graph.fitting(graph.nodes[2], 'point').map(({ name }) => name), ['stand']);
    assert.deepEqual(graph.fitting(graph.nodes[2], 'number'), [], 'all numbers are made of it');
    assert.deepEqual(graph.fitting(null, 'colour').map(({ name }) => name), ['a', 'b', 'sum', 'look', 'tint']);
  });

  test('a name changes wherever it stands', async () => {
    const { Graph, renaming } = await load('graph'), graph = new Graph(sample(), functions);
    assert.deepEqual(renaming(graph, 's', 'a', 'grain').map(({ path, value }) => [path, value]), [
      ['s.nodes[2].name', 'grain'], ['s.nodes[1].of[0]', 'grain'], ['s.nodes[1].of[3]', 'grain'], ['s.nodes[3].of', 'grain']]);
    assert.deepEqual(renaming(graph, 's', 'sum', 'all').map(({ path }) => path), ['s.nodes[1].name', 's.nodes[0].by', 's.opacity']);
  });

  test('what is taken away is bridged where that fits, and kept with a reason where not', async () => {
    const { Graph, removal } = await load('graph'), graph = new Graph(sample(), functions);
    assert.deepEqual(removal(graph, 's', 'b'), [{ op: 'set', path: 's.nodes[1].of[2]', value: 'a' }, { op: 'remove', path: 's.nodes[3]' }]);
    assert.deepEqual(removal(graph, 's', 'stand'), [{ op: 'remove', path: 's.nodes[2].at' }, { op: 'remove', path: 's.nodes[4]' }]);
    assert.deepEqual(removal(graph, 's', 'tint'), [{ op: 'remove', path: 's.nodes[5]' }]);
    assert.deepEqual(removal(graph, 's', 'look').slice(0, 2), [{ op: 'set', path: 's.nodes[5].of[0]', value: 'sum' }, { op: 'set', path: 's.colour', value: 'sum' }]);
    assert.equal(removal(graph, 's', 'a'), '“a” is used by “sum” and “b”, and nothing behind it could take its place there.');
  });

  test('another function keeps what both have, and gets what it must have', async () => {
    const { Graph, madeNode, obstacle } = await load('graph'), graph = new Graph(sample(), functions);
    const turn = (name, from) => madeNode(graph, functions, schema, name, from, graph.nodes[graph.indexOf(name)], null);
    assert.deepEqual(turn('a', 'rings').node, { name: 'a', function: 'rings', at: 'stand' }, 'a size of 4 is none of rings');
    assert.deepEqual(turn('b', 'map').node.by, 'a');
    assert.equal(turn('b', 'map').node.stops.length, 2);
    assert.equal(turn('sum', 'curve').node.of, 'a');
    assert.deepEqual(madeNode(graph, functions, schema, 'd', 'dot', {}, null), { node: { name: 'd', function: 'dot', a: 'stand', b: 'stand' }, more: [] });
    const bare = new Graph({ nodes: [] }, functions);
    assert.deepEqual(madeNode(bare, functions, schema, 'd', 'dot', {}, null).more, [{ name: 'position', function: 'position' }]);
    assert.equal(obstacle(graph, functions, graph.nodes[2], 'rings'), null);
    assert.match(obstacle(graph, functions, graph.nodes[2], 'place'), /gives a point, and “sum” takes numbers or colours/);
    assert.match(obstacle(graph, functions, graph.nodes[1], 'map'), /gives a colour, and “look” takes a number/);
  });

  test('a graph is brought to another size by one more place', async () => {
    const { placed } = await load('graph'), from = sample(), made = placed(from, functions, 2.5, [1, 0, -3]);
    assert.deepEqual(made.nodes[0], { name: 'size', function: 'place', move_x: 1, move_z: -3, scale_x: 2.5, scale_y: 2.5, scale_z: 2.5 });
    assert.equal(made.nodes[5].at, 'size');
    assert.equal(made.nodes[3].at, 'stand');
    assert.deepEqual(from, sample(), 'the original is as it was');
  });

  test('uploads of several arrays are laid out as packets are', async () => {
    const { readPacket, writeUpload } = await load('protocol');
    const made = readPacket(writeUpload({ id: 3, kind: 'é' }, { points: new Float32Array([1, 2, 3]), odd: new Uint8Array([7]), last: new Uint16Array([9, 8, 7]) }));
    assert.deepEqual([...made.arrays.points], [1, 2, 3]);
    assert.deepEqual([...made.arrays.odd], [7]);
    assert.deepEqual([...made.arrays.last], [9, 8, 7]);
  });
});

/* ---- the page ------------------------------------------------------------------------------------------------------ */

let desk;

const open = (name, change, options) => desk.openExample(name, change, options);

const solidIn = async (page) => (await state(page)).document.solids[0];
const nodeIn = async (page, name) => (await solidIn(page)).nodes.find((node) => node.name === name);
const steps = async (page) => (await state(page)).undo;
const row = (page, name) => page.locator(`[data-key="node ${name}"]`);
const menu = async (page, name, item) => {
  await page.locator(`[data-key="node ${name} menu"]`).click();
  await page.getByRole('menuitem', { name: item }).click();
};
async function saved(page) {
  await page.keyboard.press('Escape');
  await page.evaluate(() => globalThis.pith.commands.run('save'));
  await eventually('it is saved', async () => (await state(page)).saved);
  return readDocument(desk.server.document);
}
/* Until the view rests with every colour there; while it moves there is nothing to ask for. */
const fine = (page) => page.waitForFunction(() => globalThis.pith.viewport.seen() !== null && globalThis.pith.viewport.fine,
                                            undefined, { timeout: 60000, polling: 50 });

describe('computed solids in the editor', { timeout: 600000 }, () => {
  desk = new Desk();

  test('at rest pixels are what the library samples, finer than voxels', async () => {
    for (const name of ['wood.pith', 'marble.pith']) {
      const page = await open(name);
      await page.evaluate(() => globalThis.pith.viewport.look({ unlit: true }));
      const seen = await page.evaluate(() => {
        const { viewport } = globalThis.pith, { clientWidth: w, clientHeight: h } = viewport.element, list = [];
        for (let y = 0.2; y < 0.8; y += 0.04) for (let x = 0.2; x < 0.8; x += 0.04) {
          const hit = viewport.hit(Math.round(w * x) + 0.5, Math.round(h * y) + 0.5);
          if (hit) list.push({ at: [Math.round(w * x), Math.round(h * y)], point: hit.point.toArray() });
        }
        return list;
      });
      const input = seen.map(({ point }) => point.join(' ')).join('\n') + '\n';
      const asked = execFileSync(program, ['sample', desk.server.document], { input, encoding: 'utf8' }).trim().split('\n')
        .map((line) => line.split(/\s+/).map(Number));
      const distance = (colours) => colours.reduce((sum, colour, i) => sum + [0, 1, 2].reduce((all, c) =>
        all + Math.abs(colour[c] - 255 * srgb(asked[i][c])) / 3, 0), 0) / colours.length;
      await fine(page);
      await drawn(page);
      const sharp = distance(await pixels(page, seen.map(({ at }) => at)));
      await page.evaluate(() => globalThis.pith.viewport.showColours({ texture: null }, '', true));
      await drawn(page);
      const coarse = distance(await pixels(page, seen.map(({ at }) => at)));
      assert.ok(seen.length > 50, `${seen.length} points are seen`);
      assert.ok(sharp < 6, `${name}: sharp pixels are ${sharp} of 255 away`); // they are means over a pixel, points are not
      assert.ok(sharp < 0.75 * coarse, `${name}: ${sharp} beside ${coarse} of voxels`);
      await desk.opened.close();
      await desk.server.stop();
    }
  });

  test('the list follows what flows; a name changes in one step everywhere', async () => {
    const page = await open('wood.pith');
    const names = await page.locator('.nodes .list-title').allTextContents();
    assert.deepEqual(names, ['trunk', 'bend', 'grown', 'rings', 'fibre_place', 'fibres', 'fibre_tint', 'wood', 'look']);
    await row(page, 'grown').click();
    const field = page.locator('.nodes .row-more input.field').first();
    await field.fill('bent trunk');
    await field.press('Enter');
    await eventually('the name is another', () => nodeIn(page, 'bent trunk'));
    assert.deepEqual([(await nodeIn(page, 'rings')).at, (await nodeIn(page, 'fibre_place')).at], ['bent trunk', 'bent trunk']);
    assert.deepEqual(await steps(page), ['Rename grown']);
    assert.equal(await row(page, 'bent trunk').getAttribute('aria-pressed'), 'true', 'its card stays open');
    await field.fill('rings');
    await field.press('Enter');
    await page.getByText('Another function is called “rings” already.').waitFor();
    assert.deepEqual(await steps(page), ['Rename grown']);
    const document = await saved(page);
    assert.equal(document.solids[0].nodes.find(({ name }) => name === 'rings').at, 'bent trunk');
  });

  test('a slider sets an option; the picture and the saved document change', async () => {
    const page = await open('wood.pith');
    await fine(page);
    const at = [[300, 300], [400, 400], [500, 350], [350, 450], [450, 300]];
    const before = await pixels(page, at);
    await row(page, 'rings').click();
    const field = page.locator('[data-key="solids[0].nodes[3].spacing"]');
    await field.fill('0.3');
    await field.press('Enter');
    await eventually('it is set', async () => (await nodeIn(page, 'rings')).spacing === 0.3);
    await settled(page);
    await fine(page);
    const now = await pixels(page, at);
    const changed = now.filter((colour, i) => colour.some((value, c) => Math.abs(value - before[i][c]) > 12)).length;
    assert.ok(changed >= 2, `${changed} of ${at.length} pixels are others`);
    assert.equal((await saved(page)).solids[0].nodes[3].spacing, 0.3);
    assert.deepEqual(await steps(page), ['Set rings spacing']);
  });

  test('another function keeps its input; what would not fit is not offered', async () => {
    const page = await open('wood.pith');
    await row(page, 'rings').click();
    await page.locator('[data-key="function"]').click();
    const dialog = page.locator('dialog');
    assert.equal(await dialog.locator('[data-function="place"]').isDisabled(), true);
    assert.match(await dialog.locator('[data-function="place"]').textContent(), /gives a point, and “wood” takes numbers or colours/);
    await dialog.locator('input[type=search]').fill('checker');
    assert.equal(await dialog.locator('[data-function]').count(), 1);
    await page.keyboard.press('Enter');
    await eventually('it is checks', async () => (await nodeIn(page, 'rings')).function === 'checks');
    assert.deepEqual(await nodeIn(page, 'rings'), { name: 'rings', function: 'checks', at: 'grown' });
    await page.locator('[data-key="solids[0].nodes[3].size"]').waitFor();
    await page.keyboard.press('Control+z');
    await eventually('it is rings again', async () => (await nodeIn(page, 'rings')).late === 0.3);
  });

  test('inputs, operands and outputs are chosen from what fits', async () => {
    const page = await open('wood.pith');
    await row(page, 'wood').click();
    const path = 'solids[0].nodes[6].of';
    await page.locator(`[data-key="${path}+"]`).click();
    await eventually('there are three', async () => (await nodeIn(page, 'wood')).of.length === 3);
    await page.locator(`select[data-key="${path}[2]"]`).selectOption('#number');
    await eventually('it is a number', async () => typeof (await nodeIn(page, 'wood')).of[2] === 'number');
    await page.locator(`input[data-key="${path}[2]#"]`).fill('0.25');
    await page.locator(`input[data-key="${path}[2]#"]`).press('Enter');
    await eventually('it is 0.25', async () => (await nodeIn(page, 'wood')).of[2] === 0.25);
    await page.locator(`[data-key="${path}[2]^"]`).click();
    await eventually('it moved up', async () => (await nodeIn(page, 'wood')).of[1] === 0.25);
    await page.locator(`[data-key="${path}[0]-"]`).click();
    await eventually('the first is gone', async () => (await nodeIn(page, 'wood')).of.length === 2);
    assert.deepEqual((await nodeIn(page, 'wood')).of, [0.25, 'fibre_tint']);
    const options = await page.locator(`select[data-key="${path}[1]"] option`).allTextContents();
    assert.ok(!options.includes('look') && !options.includes('wood') && options.includes('a colour'), 'what is made of it is not offered');
    assert.equal(await page.locator('.nodes .badge').count(), 1, 'rings are unused now');
    await page.locator('select[data-key="solids[0].colour"]').selectOption('node rings');
    await eventually('the rings are the colour', async () => (await solidIn(page)).colour === 'rings');
    await settled(page);
    await page.evaluate(() => globalThis.pith.viewport.look({ unlit: true }));
    await fine(page);
    const grey = await pixels(page, [[300, 300], [400, 400], [500, 350]]);
    for (const [r, g, b] of grey) assert.ok(Math.max(r, g, b) - Math.min(r, g, b) <= 2, `${[r, g, b]} is grey`);
  });

  test('functions are added, duplicated and removed, each in one step', async () => {
    const page = await open('bubbles.pith');
    await page.locator('[data-key="node+"]').click();
    await page.locator('dialog [data-function="map"]').click();
    await eventually('there is a map', () => nodeIn(page, 'map'));
    assert.equal((await nodeIn(page, 'map')).by, 0.5);
    await menu(page, 'map', 'Duplicate');
    await eventually('there are two', () => nodeIn(page, 'map 2'));
    await menu(page, 'map', 'Remove');
    await eventually('the first is gone', async () => !(await nodeIn(page, 'map')));
    await menu(page, 'inside', 'Remove');
    await page.getByText('“inside” is used by “look”, and nothing behind it could take its place there.').waitFor();
    await menu(page, 'green', 'Remove'); // its number takes its place
    await eventually('green is bridged', async () => (await nodeIn(page, 'look')).b === 'which');
    assert.deepEqual(await steps(page), ['Remove green', 'Remove map', 'Duplicate map', 'Add map']);
    assert.deepEqual((await saved(page)).solids[0].nodes.map(({ name }) => name), ['inside', 'which', 'look', 'map 2']);
  });

  test('pictures show what functions give', async () => {
    const page = await open('bubbles.pith');
    await page.waitForFunction(() => document.querySelectorAll('.node-picture canvas:not([hidden])').length === 4, undefined, { timeout: 20000 });
    const [bytes, tip] = await page.evaluate(() => {
      const frame = document.querySelector('[data-node="inside"]'), canvas = frame.querySelector('canvas');
      return [[...canvas.getContext('2d').getImageData(0, 0, 64, 64).data].filter((_, i) => i % 4 === 0), frame.dataset.tip];
    });
    const low = bytes.filter((value) => value < 20).length, high = bytes.filter((value) => value > 235).length;
    assert.ok(low > 400 && high > 200, `${low} dark and ${high} bright pixels of balls in a ground`);
    assert.equal(tip, '0 to 1');
  });

  test('files are chosen where functions need them', async () => {
    const page = await open('peachey/figure8.pith', (document) => { document.bodies = document.bodies.slice(0, 1); }, { built: false });
    await page.locator('[data-key="node+"]').click();
    await page.locator('dialog [data-function="project"]').click();
    await page.locator('dialog .file', { hasText: 'woodgrain.jpg' }).first().click();
    await eventually('it projects the picture', async () =>
      (await state(page)).document.bodies[0].solids[0].nodes.some((node) => node.function === 'project' && /woodgrain\.jpg$/.test(node.image) && node.name === 'project'));
  });

  test('directions: the function brings strokes, and then their tool is of use', async () => {
    const page = await open('wood.pith');
    const tool = (name) => page.getByRole('radio', { name, exact: true }).first();
    const why = (name) => tool(name).getAttribute('data-tip');
    for (const name of ['Fill', 'Depth', 'Scale', 'Paste', 'Direction']) {
      const label = await page.evaluate((name) => globalThis.pith.toolbox.get(name).label, { Fill: 'fill', Depth: 'depth', Scale: 'scale', Paste: 'paste', Direction: 'direction' }[name]);
      assert.equal(await tool(label).getAttribute('aria-disabled'), 'true', name);
      assert.match(await why(label), /is computed/);
    }
    const direction = await page.evaluate(() => globalThis.pith.toolbox.get('direction').label);
    await page.locator('[data-key="node+"]').click();
    await page.locator('dialog [data-function="direction"]').click();
    await eventually('there is a direction', () => nodeIn(page, 'direction'));
    const { document, undo } = await state(page);
    assert.ok(document.direction.strokes.length >= 1 && document.depth.constraints.length >= 2);
    assert.deepEqual(undo, ['Add direction']);
    assert.equal(await tool(direction).getAttribute('aria-disabled'), 'false', 'strokes are of use now');
  });

  test('a computed texture from the dialog, scaled to the body, and back to a type', async () => {
    const page = await open('kiwi.pith');
    await page.evaluate(() => globalThis.pith.commands.run('type'));
    await page.locator('.type-option', { hasText: 'Wood' }).click();
    await page.getByText('Use wood', { exact: true }).click();
    await eventually('it is of wood', async () => (await state(page)).document.solid === 'wood');
    await settled(page);
    await fine(page);
    const { solids, solid } = (await state(page)).document;
    assert.deepEqual([solids.length, solid, solids[1].kind, solids[0].kind], [2, 'wood', 'procedural', 'lapped']);
    const size = solids[1].nodes[0], box = await page.evaluate(() => globalThis.pith.model.meshes.get(0).box);
    const diagonal = Math.hypot(...box[0].map((low, k) => box[1][k] - low));
    assert.ok(Math.abs(size.scale_x / (diagonal / Math.hypot(2, 1.3, 1.1)) - 1) < 1e-3, `${size.scale_x} for ${diagonal}`);
    assert.deepEqual(await steps(page), ['Make it of wood']);
    const brown = await pixels(page, [[450, 430], [430, 400], [470, 460]]);
    for (const [r, g, b] of brown) assert.ok(r > g && g > b, `${[r, g, b]} is of wood`);
    await page.evaluate(() => globalThis.pith.commands.run('type'));
    await page.locator('.type-option', { hasText: 'Granite' }).click();
    await page.getByText('Use granite', { exact: true }).click();
    await eventually('it is of granite', async () => (await state(page)).document.solid === 'granite');
    assert.equal((await state(page)).document.solids.length, 2, 'it takes the place of the wood');
    await page.evaluate(() => globalThis.pith.commands.run('type'));
    await page.locator('.type-option', { hasText: 'Layers with a grain' }).click();
    await page.getByText('Use type 1-B', { exact: true }).click();
    await eventually('it is lapped again', async () => (await state(page)).document.solid === solids[0].name);
    assert.equal((await saved(page)).solids[0].type ?? '1-B', '1-B');
  });

  test('profiles, places and finishes', async () => {
    const page = await open('wood.pith', (document) => {
      document.shape = { turned: { profile: [{ z: -1, r: 0.4, corner: true }, { z: 0, r: 0.7 }, { z: 1, r: 0.3, corner: true }] } };
      delete document.cuts;
    });
    await page.locator('[data-section=shape] > h3 > button').click();
    const at = (key) => page.locator(`[data-key="shape.turned.profile${key}"]`);
    await at('[1].r').fill('0.5');
    await at('[1].r').press('Enter');
    const profile = async () => (await state(page)).document.shape.turned.profile;
    await eventually('the radius is another', async () => (await profile())[1].r === 0.5);
    await at('[1]+').click();
    await eventually('there are four points', async () => (await profile()).length === 4);
    assert.deepEqual((await profile())[2], { z: 0.5, r: 0.4 });
    await at('[2].corner').check();
    await eventually('it is an edge', async () => (await profile())[2].corner === true);
    assert.equal(await page.locator('.profile-point').count(), 4);
    await page.locator('[data-section="shape.place"] > h4 > button').click();
    await page.locator('[data-key="place"]').click();
    await page.locator('[data-key="shape.place.turn_x"]').fill('90');
    await page.locator('[data-key="shape.place.turn_x"]').press('Enter');
    await eventually('it lies', async () => (await state(page)).document.shape.place.turn_x === 90);
    await page.locator('[data-section="shape.finish"] > h4 > button').click();
    await page.locator('[data-key="finish"]').click();
    await eventually('it is polished', async () => (await state(page)).document.finish?.reflectivity === 0.04);
    await settled(page);
    const tall = await page.evaluate(() => { const [low, high] = globalThis.pith.model.meshes.get(0).box; return high.map((x, k) => x - low[k]); });
    assert.ok(tall[1] > 1.9 && tall[2] < 1.3, `${tall}: two long, on its side`);
    assert.equal((await saved(page)).shape.turned.profile.length, 4);
  });
});

const srgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.min(1, x) ** (1 / 2.4) - 0.055);
