// What of the page can be tried without a browser: numbers along sliders, places in the schema, starting fields, what a
// fill reaches, shortcuts, colours between stops, operations on sketches.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { load } from './modules.mjs';

const root = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
const schema = JSON.parse(readFileSync(join(root, 'docs', 'pith.schema.json')));
const near = (a, b, tolerance) => assert.ok(Math.abs(a - b) <= tolerance, `${a} is not within ${tolerance} of ${b}`);

/* Every number of the schema with its limits. */
function numbersOf(node, path = '', found = []) {
  if (node && typeof node === 'object') {
    if ((node.type === 'number' || node.type === 'integer') && 'default' in node) found.push({ path, ...node });
    for (const [key, inner] of Object.entries(node)) numbersOf(inner, `${path}/${key}`, found);
  }
  return found;
}

test('what the server says is put to people as sentences', async () => {
  const { sentence } = await load('sentences');
  const said = [
    ['revision: is 2, but the document is at 3; another page was first', 'stale', 'Another page changed the document first; it is shown now.'],
    ['There is nothing to undo: this is the first step there is', 'bad argument', 'There is nothing to undo.'],
    ['There is nothing to do again: this is the last step there is', 'bad argument', 'There is nothing to redo.'],
    ['file: the name is ".a.pith", expected 1 to 200 bytes', 'bad argument', 'The name is ".a.pith", expected 1 to 200 bytes.'],
    ['file: there is a file tree.pith already; force replaces it', 'bad argument', 'There is a file tree.pith already.'],
    ['name: there is a file plum.json already, and it is not replaced; choose another name', 'bad argument', 'There is a file plum.json already.'],
    ['file: is "tree.txt", expected a name that ends with .pith', 'bad argument', 'The file is "tree.txt", expected a name that ends with .pith.'],
    ['job: no job 3 is waiting or running', 'bad argument', 'That had ended already.'],
    ['kiwi.pith: cannot be written: No space left on device', 'input/output error', 'kiwi.pith: cannot be written: No space left on device.'],
    ['solids[0]: angle_limit: is 100, expected 5 to 85', 'bad argument', 'solids[0]: angle_limit: is 100, expected 5 to 85.'],
    ['The connection to pith was lost.', 'lost', 'The connection to pith was lost.'],
  ];
  for (const [message, status, sentenced] of said) assert.equal(sentence(message, status), sentenced);
});

test('a slider reaches both ends of every range of the schema, its default, and never leaves it', async () => {
  const { travel } = await load('ui/numbers');
  let tried = 0;
  for (const { path, type, minimum: min, maximum: max, default: standard } of numbersOf(schema)) {
    const spec = { min, max, whole: type === 'integer', default: standard }, way = travel(spec);
    if (!way) continue;
    ++tried;
    near(way.at(min), 0, 1e-9);
    near(way.at(max), 1, 1e-9);
    for (let at = 0; at <= 1; at += 0.01) {
      const value = way.value(at);
      assert.ok(value >= min && value <= max, `${path}: ${value} at ${at} is not in ${min} to ${max}`);
      if (spec.whole) assert.ok(Number.isInteger(value), `${path}: ${value} is not whole`);
    }
    // Wherever the default lies, some part of the way must be left on the side it leaves open.
    const at = way.at(standard);
    assert.ok(standard === min || at > 0.005, `${path}: the default is squeezed to ${at}`);
    assert.ok(standard === max || at < 0.995, `${path}: the default is squeezed to ${at}`);
  }
  assert.ok(tried > 80, `only ${tried} sliders`);
});

test('values come back from the slider where they were put', async () => {
  const { travel } = await load('ui/numbers');
  for (const spec of [{ min: 0, max: 1 }, { min: 1, max: 65536, whole: true, default: 16 }, { min: 0, max: 1e6, default: 1 }, { min: 0.002, max: 0.1 }]) {
    const way = travel(spec);
    for (let at = 0; at <= 1; at += 0.05) {
      const value = way.value(at), again = way.value(way.at(value));
      near(again, value, 0.02 * Math.abs(value) + 1e-9);
    }
  }
});

test('numbers are read as they are written, and held within their limits', async () => {
  const { read, write } = await load('ui/numbers');
  const wide = { min: -1e12, max: 1e12 };
  for (const value of [0, 1, -1, 0.075, 1e-6, 123456789, 0.5, 1 / 3, -2.5e-7]) near(read(write(value), wide), value, Math.abs(value) * 6e-3);
  assert.equal(read('60°', { min: 10, max: 85 }), 60);
  assert.equal(read('0,5', { min: 0, max: 1 }), 0.5);
  assert.equal(read('7', { min: 0, max: 1 }), 1);
  assert.equal(read('3.6', { min: 0, max: 10, whole: true }), 4);
  for (const nothing of ['', 'abc', '1e', '--2', 'NaN', 'Infinity']) assert.equal(read(nothing, wide), null, nothing);
});

test('arrow keys step by round amounts that suit the range', async () => {
  const { arrowStep } = await load('ui/numbers');
  near(arrowStep({ min: 0, max: 1 }, 0.5), 0.01, 1e-12);
  near(arrowStep({ min: 0, max: 180 }, 30), 1, 1e-12);
  assert.equal(arrowStep({ min: 1, max: 65536, whole: true }, 16), 1);
  near(arrowStep({ min: 1e-9, max: 1e9 }, 0.3), 0.01, 1e-12);
});

test('the schema of a place follows references and the kind that the document names', async () => {
  const { fieldsAt, schemaAt, valueAt, plainFields } = await load('schema');
  const document = { solids: [{ kind: 'grid', file: 'a.nrrd' }, { kind: 'lapped', exemplar: { layered: { noises: [{}] } } }] };
  assert.deepEqual(fieldsAt(schema, document, 'solids[0]').map((field) => field.key), Object.keys(schema.$defs.grid.properties));
  assert.deepEqual(fieldsAt(schema, document, 'solids[1]').map((field) => field.key), Object.keys(schema.$defs.lapped.properties));
  // A place that is not there yet.
  assert.deepEqual(fieldsAt(schema, {}, 'bodies[3].solids[1].exemplar.layered.noises[0]').map((field) => field.key), Object.keys(schema.$defs.noise.properties));
  assert.equal(schemaAt(schema, document, 'solids[1].nothing'), null);
  assert.equal(valueAt(document, 'solids[1].kind'), 'lapped');
  assert.equal(valueAt(document, 'solids[7].kind'), undefined);
  for (const [name, place] of [['render', 'render'], ['volume', 'volume'], ['lapped', 'solids[1]'], ['tets', 'shape.tets']]) {
    for (const field of plainFields(schema, document, place)) {
      const stated = schema.$defs[name].properties[field.key];
      assert.equal(field.default, stated.default, `${place}.${field.key}`);
      if (field.kind === 'number') assert.deepEqual([field.min, field.max, field.whole], [stated.minimum, stated.maximum, stated.type === 'integer']);
      assert.ok(field.help.length > 3 && field.label.length > 1, `${place}.${field.key} says nothing`);
    }
  }
});

/* An ellipsoid about a centre as the fake server makes it: longitudes and latitudes. */
function ellipsoid([cx, cy, cz], [rx, ry, rz], rows = 32, columns = 48) {
  const positions = [], triangles = [];
  for (let i = 0; i <= rows; ++i) for (let j = 0; j < columns; ++j) {
    const polar = (Math.PI * i) / rows, round = (2 * Math.PI * j) / columns;
    positions.push(cx + rx * Math.sin(polar) * Math.cos(round), cy + ry * Math.sin(polar) * Math.sin(round), cz + rz * Math.cos(polar));
  }
  for (let i = 0; i < rows; ++i) for (let j = 0; j < columns; ++j) {
    const a = i * columns + j, b = i * columns + ((j + 1) % columns), c = a + columns, d = b + columns;
    if (i > 0) triangles.push(a, c, b);
    if (i < rows - 1) triangles.push(b, c, d);
  }
  return { positions, triangles };
}

function meshOf(...bodies) {
  const positions = [], triangles = [];
  for (const body of bodies) {
    const first = positions.length / 3;
    positions.push(...body.positions);
    triangles.push(...body.triangles.map((v) => v + first));
  }
  const low = [0, 1, 2].map((k) => Math.min(...positions.filter((_, i) => i % 3 === k))), high = [0, 1, 2].map((k) => Math.max(...positions.filter((_, i) => i % 3 === k)));
  return { positions: Float32Array.from(positions), triangles: Uint32Array.from(triangles), painted: new Float32Array(triangles.length / 3).fill(NaN),
           box: [low, high], closed: true, report: {} };
}

test('a core runs along the longest axis, a fifth away from either end', async () => {
  const { coreSegments } = await load('fields');
  const cores = coreSegments(meshOf(ellipsoid([0.3, 0, -1], [0.5, 0.7, 2]), ellipsoid([5, 1, 0], [3, 0.6, 0.5])));
  assert.equal(cores.length, 2);
  const [[a, b], [c, d]] = cores.map((core) => core.slice().sort((p, q) => p[2] + p[0] - q[2] - q[0]));
  // The ellipsoid's axis is 4 long, from -3 to 1: the core from -3 + 0.8 to 1 - 0.8.
  [[a, [0.3, 0, -2.2]], [b, [0.3, 0, 0.2]], [c, [3.2, 1, 0]], [d, [6.8, 1, 0]]].forEach(([found, expected]) =>
    found.forEach((x, k) => near(x, expected[k], 0.02)));
});

test('a core keeps to the inside where the line leaves the body, and a hollow counts as outside', async () => {
  const { coreSegments } = await load('fields');
  // A sphere with a smaller one inside turned outside in: the longest stretch inside is one of the two walls.
  const outer = ellipsoid([0, 0, 0], [1, 1, 2]), inner = ellipsoid([0, 0, 0.2], [0.5, 0.5, 1]);
  inner.triangles = inner.triangles.map((_, i) => inner.triangles[3 * Math.floor(i / 3) + [0, 2, 1][i % 3]]);
  const cores = coreSegments(meshOf(outer, inner));
  assert.equal(cores.length, 1);
  const [low, high] = cores[0].map((point) => point[2]).sort((x, y) => x - y);
  near(low, -2 + 1.2 / 5, 0.03);
  near(high, -0.8 - 1.2 / 5, 0.03);
});

test('a type is given what it lacks and nothing else', async () => {
  const { startingOperations } = await load('fields');
  const mesh = meshOf(ellipsoid([0, 0, 0], [1, 1, 2])), none = { depth: false, direction: false, vectors: false, scale: false };
  const names = (needs, present) => startingOperations({ ...none, ...needs }, { ...none, ...present }, mesh).map((operation) => operation.op);
  assert.deepEqual(names({ scale: true }, {}), ['scale.point']);
  assert.deepEqual(names({ depth: true, direction: true }, {}), ['depth.face', 'depth.stroke', 'direction.stroke']);
  assert.deepEqual(names({ depth: true, direction: true }, { depth: true }), ['direction.stroke']);
  assert.deepEqual(names({ vectors: true, scale: true }, { scale: true }), ['vectors.inside']);
  assert.deepEqual(names({ depth: true }, { depth: true }), []);
  assert.throws(() => startingOperations({ ...none, depth: true }, none, undefined), /mesh is not here/);
  // Half of the cube root of the volume: 4/3 pi 1 1 2, a little less for being faceted.
  const [{ size }] = startingOperations({ ...none, scale: true }, none, mesh);
  near(size, 0.5 * Math.cbrt((8 / 3) * Math.PI), 0.02);
});

test('a fill stops at creases and at other depths', async () => {
  const { Reach } = await load('reach');
  const corners = [];
  for (let i = 0; i < 8; ++i) corners.push(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  const reach = new Reach(Float32Array.from(corners), Uint32Array.from(quads.flatMap(([a, b, c, d]) => [a, b, c, a, c, d])));
  const bare = new Float32Array(12).fill(NaN);
  assert.deepEqual(reach.from(0, bare, 30).sort((a, b) => a - b), [0, 1]);
  assert.equal(reach.from(5, bare, 89.9).length, 2);
  assert.equal(reach.from(5, bare, 90).length, 12);
  const painted = bare.slice();
  painted.fill(0.5, 0, 2);
  assert.equal(reach.from(6, painted, 180).length, 10);
  assert.equal(reach.from(1, painted, 180).length, 2);
});

test('a shortcut means one key', async () => {
  const { matches } = await load('keyboard');
  const press = (key, more = {}) => ({ key, code: '', ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...more });
  assert.ok(matches(press('z', { ctrlKey: true }), 'Ctrl+Z'));
  assert.ok(matches(press('z', { metaKey: true }), 'Ctrl+Z'));
  assert.ok(!matches(press('z', { ctrlKey: true, shiftKey: true }), 'Ctrl+Z'));
  assert.ok(matches(press('Z', { ctrlKey: true, shiftKey: true }), 'Ctrl+Shift+Z'));
  assert.ok(!matches(press('z'), 'Ctrl+Z'));
  assert.ok(matches(press('?', { shiftKey: true }), '?'));
  assert.ok(matches(press('&', { code: 'Digit1' }), '1'), 'digits go by where the key is');
  assert.ok(matches(press('!', { code: 'Digit1', shiftKey: true }), 'Shift+1'));
  assert.ok(!matches(press('1', { code: 'Digit1', ctrlKey: true }), '1'));
  assert.ok(matches(press(' '), 'Space'));
  assert.ok(matches(press('h', { altKey: true }), 'Alt+H') && !matches(press('h', { altKey: true }), 'H'));
});

test('colours between stops are mixed, those beyond are the last', async () => {
  const { colourAt } = await load('ui/gradient');
  const stops = [{ at: 0.8, colour: '#ffffff', opacity: 1 }, { at: 0.4, colour: '#000000', opacity: 1 }];
  assert.equal(colourAt(stops, 0.5), '#404040');
  assert.equal(colourAt(stops, 0.1), '#000000');
  assert.equal(colourAt(stops, 0.9), '#ffffff');
  assert.equal(colourAt([], 0.5), '#808080');
});

test('every field a type needs has a word, and every type an exemplar that is shipped', async () => {
  const { typeTable, needWords } = await load('types');
  assert.deepEqual(typeTable.map((facts) => facts.type), schema.$defs.lapped.properties.type.enum);
  for (const { exemplar } of typeTable) readFileSync(join(root, 'examples', 'exemplars', `${exemplar}.json`));
  assert.deepEqual(Object.keys(needWords).sort(), ['depth', 'direction', 'scale', 'vectors']);
});

test('what is sketched of a body like another is written where its surfaces stand', async () => {
  const { addSurface, curvesOf, curveOperation, freeSurfaceName, renameOperations, sketchPath } = await load('sketch/drawn');
  const vertical = [[0, 1], [1, 0], [0, -1]], one = { name: 'one', shape: { surfaces: ['skin'] }, sketch: { folds: 3 },
    surfaces: [{ name: 'skin', kind: 'around', vertical }], solids: [{ name: 'inside', kind: 'diffusion', surfaces: ['skin'] }] };
  const state = { body: 1, document: { bodies: [one, { name: 'other', like: 'one', shape: { place: { move_y: 2 } } }] } };
  const [curve] = curvesOf(state, new Map());
  assert.deepEqual(curveOperation(state, curve, curve.knots, 0).body, 'one');
  assert.equal(sketchPath(state), 'bodies[0].sketch');
  assert.deepEqual(addSurface(state, { name: 'core' }).map(({ path }) => path), ['bodies[0].surfaces[1]', 'bodies[0].solids[0].surfaces[1]']);
  assert.deepEqual(renameOperations(state, 0, 'peel').map(({ path }) => path),
    ['bodies[0].surfaces[0].name', 'bodies[0].shape.surfaces[0]', 'bodies[0].solids[0].surfaces[0]']);
  state.document.bodies[1] = { ...state.document.bodies[1], surfaces: one.surfaces };
  assert.equal(freeSurfaceName(state, 'core'), 'core');
  assert.equal(freeSurfaceName(state, 'skin'), 'skin 2');
  assert.equal(sketchPath({ ...state, document: { ...state.document } }), 'bodies[1].sketch', 'it has surfaces of its own');
});
