// A server that speaks the editor's protocol and builds nothing: for the page's own tests. It holds a document, does
// operations the way document.md says, pretends to build, and answers with small packets. Only node's own modules.

import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { deflateSync } from 'node:zlib';
import { operate } from './fake_operations.mjs';
import { ballSolid, meridians, packet, sphereLayer, sphereMesh, sphereView, voxelsOf } from './fake_packets.mjs';

const root = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.jpg': 'image/jpeg' };
export const token = 'test';

/** Starts a server of the page in `folder` on a free port. `document` is what it holds; `options.delay`, milliseconds a
    build takes. Returns its address, the state to look at, and the way to end it. */
export async function startFake(folder, document, options = {}) {
  const fake = new Fake(document, options);
  const server = createServer((request, response) => sendFile(folder, request, response));
  server.on('upgrade', (request, socket) => fake.accept(request, socket));
  const start = (port) => new Promise((resolve) => server.listen(port, '127.0.0.1', resolve));
  await start(0);
  return {
    address: `http://127.0.0.1:${server.address().port}/#${token}`, fake, start,
    async stop() { fake.drop(); server.closeAllConnections(); await new Promise((resolve) => server.close(resolve)); },
  };
}

function sendFile(folder, request, response) {
  const name = normalize(request.url.split('?')[0]).replace(/^\/$/, '/index.html');
  try {
    const bytes = readFileSync(join(folder, name));
    response.writeHead(200, { 'Content-Type': types[extname(name)] ?? 'application/octet-stream', 'Content-Security-Policy': policy(request) }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
}

/* As strict as the real server's. */
const policy = (request) => `default-src 'self'; connect-src 'self' ws://${request.headers.host}; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'`;

const needs = {
  '0-A': [0, 0, 0, 1], '0-B': [0, 0, 1, 1], '0-C': [1, 1, 0, 1], '1-A': [1, 0, 0, 0], '1-B': [1, 1, 0, 0],
};

export class Fake {
  constructor(document, { delay = 300, saved = true, recovered = false, automatic = false, built = true } = {}) {
    this.history = [{ document, name: 'Opened' }];
    this.at = 0;
    this.revision = 1;
    this.savedAt = saved ? document : null;
    this.recovered = recovered;
    this.automatic = automatic;
    this.delay = delay;
    this.shown = built ? JSON.stringify(solidPart(document)) : '';
    this.sockets = new Set();
    this.token = token;
    this.jobs = 0;
    this.timers = new Map();
    this.asked = [];                  // every request, for tests to look at
    this.changedOnDisk = false;
    this.documents = ['kiwi.pith', 'tree.pith'];
    this.viewWhy = null;
    this.broken = [];                 // recipes that cannot be read
    this.serial = 0;
  }

  get document() { return this.history[this.at].document; }

  accept(request, socket) {
    const address = new URL(request.url, 'http://localhost');
    if (address.searchParams.get('token') !== this.token) return socket.end('HTTP/1.1 403 Forbidden\r\n\r\n');
    const key = createHash('sha1').update(request.headers['sec-websocket-key'] + '258EAFA5-E914-47DA-95CA-C5AB0DC85B11').digest('base64');
    socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Protocol: pith\r\nSec-WebSocket-Accept: ${key}\r\n\r\n`);
    this.sockets.add(socket);
    let waiting = Buffer.alloc(0);
    socket.on('data', (bytes) => {
      waiting = Buffer.concat([waiting, bytes]);
      for (let frame; (frame = readFrame(waiting));) {
        waiting = waiting.subarray(frame.size);
        if (frame.opcode === 8) socket.end();
        else if (frame.opcode === 1) this.receive(socket, JSON.parse(frame.payload.toString()));
        else if (frame.opcode === 2) this.receive(socket, readUpload(frame.payload));
      }
    });
    socket.on('error', () => {});
    socket.on('close', () => this.sockets.delete(socket));
  }

  /** Cuts every connection, as when a server ends. */
  drop() { for (const socket of this.sockets) socket.destroy(); for (const timer of this.timers.values()) clearTimeout(timer); }

  receive(socket, request) {
    this.asked.push(request);
    const answer = (keys) => socket.write(frameOf(JSON.stringify({ id: request.id, ok: true, ...keys })));
    try {
      this.answer(request, answer, socket);
    } catch (reason) {
      socket.write(frameOf(JSON.stringify({ id: request.id, ok: false, status: reason.status ?? 'bad argument', message: reason.message })));
    }
  }

  answer(request, answer, socket) {
    switch (request.do) {
      case 'hello':
        answer({ ...this.state(), version: '0.3.0', path: '/home/ada/models/kiwi.pith', file: 'kiwi.pith', socket: 1, automatic: this.automatic,
                 schema: JSON.parse(readFileSync(join(root, 'docs', 'pith.schema.json'))),
                 types: Object.fromEntries(Object.entries(needs).map(([type, [depth, direction, vectors, scale]]) =>
                   [type, { depth: !!depth, direction: !!direction, vectors: !!vectors, scale: !!scale }])), templates: ['kiwi', 'tree'] });
        return this.sendModel(socket);
      case 'apply': return this.change(request, answer, () => {
        const next = operate(this.document, request.operations);
        this.history = [...this.history.slice(0, this.at + 1), { document: next, name: request.name }];
        this.at += 1;
      });
      case 'undo': return this.change(request, answer, () => { if (this.at === 0) throw new Error('There is nothing to undo: this is the first step there is'); this.at -= 1; });
      case 'redo': return this.change(request, answer, () => { if (this.at + 1 >= this.history.length) throw new Error('There is nothing to do again: this is the last step there is'); this.at += 1; });
      case 'revert': return this.change(request, answer, () => {
        this.history = [...this.history.slice(0, this.at + 1), { document: this.savedAt, name: 'Go back to the saved document' }];
        this.at += 1;
      });
      case 'save':
        this.save(request);
        answer({ file: request.file ?? 'kiwi.pith' });
        return this.tell(this.event());
      case 'update': answer({ job: ++this.jobs }); return this.build(this.jobs, request.what);
      case 'cancel': answer({}); return this.cancel(request.job);
      case 'automatic': this.automatic = request.on; answer({}); return this.tell({ event: 'automatic', on: request.on });
      case 'files': return answer({ files: this.filesOf(request.kind) });
      case 'recipe': return answer({ recipe: JSON.parse(readFileSync(join(root, 'examples', request.path))) });
      case 'exemplar':
        if (/broken/.test(request.exemplar?.recipe)) throw new Error(`${request.exemplar.recipe}: line 3: ',' expected near 'stops'`);
        return socket.write(frameOf(voxelsOf(request, this.document, root), 2));
      case 'layer': return socket.write(frameOf(sphereLayer(request), 2));
      case 'lines': return socket.write(frameOf(meridians(request), 2));
      case 'section': throw new Error(`This server has no ${request.do}.`);
      case 'picture': answer({ job: ++this.jobs }); return this.picture(this.jobs, request);
      case 'file.put': return answer({ path: request.name });
      default: throw new Error(`There is no request ${request.do}.`);
    }
  }

  change(request, answer, step) {
    if (request.revision !== this.revision) throw Object.assign(new Error(`Another page was first: the document is at revision ${this.revision}, and this was meant for ${request.revision}; look at what it is now, and do it again`), { status: 'stale' });
    const before = { document: this.document, at: this.at, history: this.history };
    step();
    if (request.do === 'apply' && JSON.stringify(this.document) === JSON.stringify(before.document)) { // no change is no step
      Object.assign(this, { at: before.at, history: before.history });
      return answer({ revision: this.revision });
    }
    this.revision += 1;
    this.tell(this.event());
    answer({ revision: this.revision });
    this.sendView();
    if (this.automatic && this.shown !== JSON.stringify(solidPart(this.document))) this.build(++this.jobs, 'solid');
  }

  save({ file = 'kiwi.pith', force }) {
    if (file !== 'kiwi.pith') {
      if (this.documents.includes(file) && !force) throw new Error(`file: there is a file ${file} already; force replaces it`);
      this.documents.push(file);
      return;
    }
    if (this.changedOnDisk && !force) throw Object.assign(new Error('kiwi.pith was changed or removed by somebody else since it was read; save with force to replace it, or revert to it'), { status: 'changed on disk' });
    this.savedAt = this.document;
    this.recovered = false;
  }

  filesOf(kind) {
    const own = (path) => ({ path, name: path.split('/').pop(), shipped: false });
    if (kind === 'document') return this.documents.map(own);
    if (kind !== 'recipe') return [];
    return [own('exemplars/kiwi.json'), ...this.broken.map(own), ...recipes.map((name) => ({ path: `exemplars/${name}.json`, name, shipped: true }))];
  }

  state() {
    const { document } = this, shown = this.shown === JSON.stringify(solidPart(document));
    const bodies = (document.bodies ?? [document]).map((body) => {
      const solid = body.solids?.find((each) => each.name === body.solid) ?? body.solids?.[0];
      const type = solid?.kind === 'lapped' ? solid.type ?? '1-B' : '', need = needs[type] ?? [];
      const lacks = need[0] && !body.depth ? 'depth' : need[1] && !body.direction ? 'direction' : need[2] && !body.vectors ? 'vectors' : need[3] && !body.scale ? 'scale' : null;
      return { name: body.name ?? '', type, built: { mesh: true, tets: shown, fields: shown, solid: shown && !!solid }, shown,
               why: lacks ? `solids[0]: type ${type} needs a ${lacks} field; give the body "${lacks}", or take another type` : null };
    });
    return { revision: this.revision, document, name: this.history[this.at].name, undo: this.history.slice(1, this.at + 1).map((step) => step.name).reverse(),
             redo: this.history.slice(this.at + 1).map((step) => step.name), saved: this.savedAt === document, recovered: this.recovered, bodies, view: { why: this.viewWhy } };
  }

  event() { return { event: 'document', by: 1, ...this.state() }; }

  tell(event) { for (const socket of this.sockets) socket.write(frameOf(JSON.stringify(event))); }

  sendModel(socket) {
    (this.document.bodies ?? [this.document]).forEach((_, body) => socket.write(frameOf(sphereMesh(body, ++this.serial), 2)));
    if (this.shown) for (const bytes of this.modelPackets()) socket.write(frameOf(bytes, 2));
  }

  modelPackets() {
    const solids = (this.document.bodies ?? [this.document]).map((_, body) => ballSolid(body, ++this.serial));
    return [...solids, sphereView(this.document, this.revision, ++this.serial)];
  }

  sendView() { if (this.shown) for (const socket of this.sockets) socket.write(frameOf(sphereView(this.document, this.revision, ++this.serial), 2)); }

  build(job, what) {
    const event = (state, fraction, keys = {}) => this.tell({ event: 'job', job, what, state, fraction, text: 'Filling with patches', ...keys });
    const steps = 10;
    const step = (i) => {
      if (i < steps) {
        event('running', i / steps);
        this.timers.set(job, setTimeout(() => step(i + 1), this.delay / steps));
        return;
      }
      this.timers.delete(job);
      this.shown = JSON.stringify(solidPart(this.document));
      event('done', 1, { seconds: 2.34, times: { shape: 0.12, tets: 0.3, fields: 0.21, exemplar: 0.4, fill: 1.3, cut: 0.004 } });
      this.tell(this.event());
      for (const bytes of this.modelPackets()) for (const socket of this.sockets) socket.write(frameOf(bytes, 2));
    };
    event('waiting', 0);
    step(0);
  }

  cancel(job) {
    clearTimeout(this.timers.get(job));
    this.timers.delete(job);
    this.tell({ event: 'job', job, what: 'solid', state: 'cancelled', fraction: 0, text: '' });
  }

  picture(job, { width, height }) {
    setTimeout(() => {
      const bytes = png(64, 48, (x, y) => [90 + x, 120 + y, 60]);
      for (const socket of this.sockets) socket.write(frameOf(packet({ kind: 'picture', job, width, height, final: true }, { png: ['u8', bytes] }), 2));
      this.tell({ event: 'job', job, what: 'picture', state: 'done', fraction: 1, text: '', seconds: 0.2 });
    }, this.delay / 3);
  }
}

/* What a build depends on: everything but cuts, camera and pictures. */
function solidPart({ cuts, parts, camera, render, volume, title, ...rest }) { return rest; }

const recipes = ['kiwi', 'watermelon', 'sponge', 'muscle', 'flattened', 'carrot', 'cherry', 'tree', 'limestone'];

/* ---- frames of RFC 6455 ------------------------------------------------------------------------------------------ */

function readFrame(bytes) {
  if (bytes.length < 2) return null;
  let length = bytes[1] & 127, at = 2;
  if (length === 126) { if (bytes.length < 4) return null; length = bytes.readUInt16BE(2); at = 4; }
  else if (length === 127) { if (bytes.length < 10) return null; length = Number(bytes.readBigUInt64BE(2)); at = 10; }
  const masked = bytes[1] & 128, mask = masked ? bytes.subarray(at, at + 4) : null;
  at += masked ? 4 : 0;
  if (bytes.length < at + length) return null;
  const payload = Buffer.from(bytes.subarray(at, at + length));
  if (mask) for (let i = 0; i < payload.length; ++i) payload[i] ^= mask[i % 4];
  return { opcode: bytes[0] & 15, payload, size: at + length };
}

function frameOf(data, opcode = 1) {
  const payload = Buffer.from(data), { length } = payload;
  const head = length < 126 ? Buffer.from([128 | opcode, length]) : length < 65536 ? Buffer.alloc(4) : Buffer.alloc(10);
  head[0] = 128 | opcode;
  if (length >= 65536) { head[1] = 127; head.writeBigUInt64BE(BigInt(length), 2); }
  else if (length >= 126) { head[1] = 126; head.writeUInt16BE(length, 2); }
  return Buffer.concat([head, payload]);
}

function readUpload(payload) {
  const length = payload.readUInt32LE(0), head = JSON.parse(payload.subarray(4, 4 + length).toString());
  return { ...head, bytes: payload.subarray(4 + length) };
}

/* A PNG of a function of the pixel. */
function png(width, height, colour) {
  const rows = Buffer.alloc(height * (1 + 3 * width));
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) rows.set(colour(x, y), y * (1 + 3 * width) + 1 + 3 * x);
  const crcs = Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n >>> 0; });
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]), ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length, 0);
    ends.writeUInt32BE(([...body].reduce((crc, byte) => crcs[(crc ^ byte) & 255] ^ (crc >>> 8), 0xffffffff) ^ -1) >>> 0, 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const size = Buffer.alloc(13);
  size.writeUInt32BE(width, 0);
  size.writeUInt32BE(height, 4);
  size.set([8, 2, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), chunk('IHDR', size), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}
