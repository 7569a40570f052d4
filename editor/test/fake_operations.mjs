// The operations of document.md on plain JSON, as far as the page's tests go; refusals are thrown as Errors.

/** Does operations one after another; the document given is left as it is. */
export function operate(document, operations) {
  const next = structuredClone(document);
  for (const operation of operations) {
    const act = acts[operation.op];
    if (!act) throw new Error(`operation: op: there is no "${operation.op}"`);
    act(next, bodyOf(next, operation), operation);
  }
  return next;
}

function bodyOf(document, { body }) {
  if (!document.bodies) return document;
  const found = document.bodies.find((each) => each.name === body);
  if (!found && body !== undefined) throw new Error(`operation: body: no body is called "${body}"`);
  return found;
}

function solidOf(body, name) {
  const solid = body.solids?.find((each) => each.name === (name ?? body.solid)) ?? body.solids?.[0];
  if (!solid) throw new Error('operation: the body has no solid');
  return solid;
}

const steps = (path) => [...path.matchAll(/([^.[\]]+)|\[(\d+)\]/g)].map(([, key, index]) => (index === undefined ? key : Number(index)));

function setAt(document, path, value) {
  const all = steps(path), last = all.pop();
  let at = document;
  for (const [i, step] of all.entries()) at = at[step] ??= typeof (all[i + 1] ?? last) === 'number' ? [] : {};
  at[last] = value;
}

function removeAt(document, path) {
  const all = steps(path), last = all.pop(), at = all.reduce((value, step) => value?.[step], document);
  if (at === undefined || !(last in at)) throw new Error(`operation: path: there is no ${path}`);
  if (Array.isArray(at)) at.splice(last, 1);
  else delete at[last];
}

function constrain(body, constraint) { ((body.depth ??= { constraints: [] }).constraints ??= []).push(constraint); }

/* Faces have one depth at most; those taken leave the constraints they were in. */
function unpaint(body, faces) {
  const constraints = body.depth?.constraints ?? [];
  for (const constraint of constraints) {
    if (faces === 'all' && (constraint.faces || constraint.facing)) constraint.faces = [];
    else if (Array.isArray(constraint.faces)) constraint.faces = constraint.faces.filter((face) => !faces.includes(face));
  }
  if (body.depth) body.depth.constraints = constraints.filter((each) => !each.faces || each.faces === 'all' || each.faces.length > 0);
}

const facesOf = ({ face, faces, ray }) => faces ?? (face !== undefined ? [face] : ray ? [0] : []);
const moved = ({ op, body, solid, index, ...rest }) => rest;

const acts = {
  set: (document, _, { path, value }) => setAt(document, path, value),
  remove: (document, _, { path }) => removeAt(document, path),
  'depth.fill': (_, body, operation) => { unpaint(body, facesOf(operation)); constrain(body, { faces: facesOf(operation), depth: operation.depth }); },
  'depth.face': (_, body, operation) => { unpaint(body, facesOf(operation)); constrain(body, { faces: facesOf(operation), depth: operation.depth }); },
  'depth.erase': (_, body, operation) => unpaint(body, facesOf(operation)),
  'depth.stroke': (_, body, { points, depth }) => constrain(body, { stroke: points, depth }),
  'depth.points': (_, body, { points, depth }) => constrain(body, { points, depth }),
  'direction.stroke': (_, body, { points }) => { (body.direction ??= { strokes: [] }).strokes.push(points); },
  'direction.clear': (_, body) => { delete body.direction; },
  'vectors.surface': (_, body, { points }) => { ((body.vectors ??= {}).surface ??= []).push(points); },
  'vectors.inside': (_, body, { points }) => { ((body.vectors ??= {}).inside ??= []).push(points); },
  'vectors.clear': (_, body) => { delete body.vectors; },
  'scale.point': (_, body, { point, size }) => { (body.scale ??= { points: [] }).points.push({ point, size }); },
  'scale.clear': (_, body) => { delete body.scale; },
  'stroke.remove': (_, body, { list, index }) => {
    const at = { direction: body.direction?.strokes, 'vectors.surface': body.vectors?.surface, 'vectors.inside': body.vectors?.inside, depth: body.depth?.constraints }[list];
    if (!at?.length) throw new Error(`operation: list: ${list} has no strokes`);
    at.splice(index ?? at.length - 1, 1);
    if (list === 'direction' && at.length === 0) delete body.direction;
    if (list === 'depth' && at.length === 0) delete body.depth;
  },
  'paste.add': (_, body, operation) => { (solidOf(body, operation.solid).pastes ??= []).push(moved(operation)); },
  'paste.move': (_, body, operation) => { const { pastes } = solidOf(body, operation.solid); Object.assign(pastes[operation.index ?? pastes.length - 1], moved(operation)); },
  'paste.remove': (_, body, operation) => { const { pastes } = solidOf(body, operation.solid); pastes.splice(operation.index ?? pastes.length - 1, 1); },
  'cut.plane': (document, _, { plane, keep, gap, separate }) => { (document.cuts ??= []).push(JSON.parse(JSON.stringify({ plane, keep, gap, separate }))); },
  'cut.stroke': (document, _, { stroke, keep, gap, separate }) => { (document.cuts ??= []).push(JSON.parse(JSON.stringify({ stroke, keep, gap, separate }))); },
  'cut.remove': (document, _, { index }) => { document.cuts.splice(index ?? document.cuts.length - 1, 1); },
  'solid.choose': (_, body, { name }) => { body.solid = name; },
  'solid.type': (_, body, { name, type }) => { solidOf(body, name).type = type; },
  'part.hide': (document, _, { at }) => part(document, at, { hidden: true }),
  'part.show': (document, _, { at, all }) => {
    for (const each of document.parts ?? []) if (all || each.at.every((x, i) => x === at[i])) each.hidden = false;
  },
  'part.together': (document) => { for (const each of document.parts ?? []) delete each.offset; },
  'part.move': (document, _, { at, offset }) => part(document, at, { offset }),
};

function part(document, at, keys) {
  const known = (document.parts ??= []).find((each) => each.at.every((x, i) => x === at[i]));
  if (known) Object.assign(known, keys);
  else document.parts.push({ at, ...keys });
}
