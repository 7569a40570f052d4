// Every kind of GLB that the program writes, judged by the Khronos validator: no errors, no warnings.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import validator from 'gltf-validator';
import { program, workFolder } from './harness.mjs';

let folder;

const pith = (...words) => execFileSync(program, words, { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] }).toString();

async function validate(name) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, name))), { uri: name, maxIssues: 0 });
  const { numErrors, numWarnings, messages } = report.issues;
  const said = messages.filter(({ severity }) => severity < 2).slice(0, 5);
  assert.deepEqual([numErrors, numWarnings], [0, 0], `${name}: ${JSON.stringify(said)}`);
  assert.equal(report.mimeType, 'model/gltf-binary');
  return report.info;
}

describe('glTF', { timeout: 600000 }, () => {
  before(() => { folder = workFolder(); });
  after(() => rmSync(folder, { recursive: true, force: true }));

  test('a baked atlas: one mesh, one picture, one material', async () => {
    const told = JSON.parse(pith('bake', 'examples/kiwi.pith', '-o', 'kiwi.glb', '--density', '60', '--json'));
    const info = await validate('kiwi.glb');
    assert.equal(info.version, '2.0');
    assert.equal(info.totalTriangleCount, told.triangles);
    assert.equal(info.totalVertexCount, told.vertices);
    assert.equal(info.hasTextures, true);
    assert.deepEqual([info.drawCallCount, info.materialCount, info.maxUVs, info.maxAttributes], [1, 1, 1, 3]);
    const [picture] = info.resources.filter(({ image }) => image);
    assert.equal(picture.mimeType, 'image/png');
    assert.deepEqual([picture.image.width, picture.image.height], [told.width, told.height]);
    assert.equal(picture.image.bits, 8);
  });

  test('baked bodies and their pieces share one atlas', async () => {
    pith('bake', 'examples/cake.pith', '-o', 'cake.glb', '--density', '40', '--margin', '2', '--stretch', '1.6');
    assert.equal((await validate('cake.glb')).drawCallCount, 1);
  });

  test('halves of a cut, with sharp and with shared borders', async () => {
    pith('cut', 'examples/kiwi.pith', '--out', 'sharp', '--plane', '0,0,0,0.1,0,1');
    pith('cut', 'examples/kiwi.pith', '--out', 'shared', '--plane', '0,0,0,0.1,0,1', '--watertight', '--edge', '0.1');
    for (const stem of ['sharp', 'shared'])
      for (const number of [1, 2]) assert.equal((await validate(`${stem}-${number}.glb`)).hasTextures, false);
  });

  test('streamlines and arrows', async () => {
    pith('field', 'examples/kiwi.pith', '-o', 'lines.glb');
    assert.ok((await validate('lines.glb')).drawCallCount > 50, 'a line each');
    pith('field', 'examples/kiwi.pith', '-o', 'arrows.glb', '--glyphs');
    await validate('arrows.glb');
  });
});
