// Holds the objects of a YAML stream on standard input against the schemas of Kubernetes and KEDA.
//   kubectl kustomize FOLDER | node schemas.mjs MODULES
// MODULES is where `npm install kubernetes-models @kubernetes-models/keda js-yaml` put node_modules.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { resolve } from 'node:path';

const require = createRequire(resolve(process.argv[2], 'index.js'));
const yaml = require('js-yaml');

// The validators let unknown fields pass but never look at them: so whatever is not read is unknown.
function watched(value, place, unread) {
  if (value === null || typeof value !== 'object') return value;
  const copy = Array.isArray(value) ? [] : {};
  for (const [key, field] of Object.entries(value)) {
    unread.add(`${place}/${key}`);
    copy[key] = watched(field, `${place}/${key}`, unread);
  }
  return new Proxy(copy, {
    get(target, key) {
      unread.delete(`${place}/${String(key)}`);
      return target[key];
    },
  });
}

let faults = 0;
for (const object of yaml.loadAll(readFileSync(0, 'utf8'))) {
  const [group, version] = object.apiVersion.includes('/')
    ? object.apiVersion.split('/') : ['', object.apiVersion];
  const models = group === 'keda.sh' ? '@kubernetes-models/keda' : 'kubernetes-models';
  const Model = require([models, group, version, object.kind].filter(Boolean).join('/'))[object.kind];
  const found = [];
  const unread = new Set();
  try {
    Model.prototype.validate.call(watched(object, '', unread));
    found.push(...[...unread].map((place) => `${place} is no field`));
  } catch (error) {
    found.push(error.message);
  }
  for (const text of found) console.log(`${object.kind} ${object.metadata.name}: ${text}`);
  faults += found.length;
}
process.exit(faults ? 1 : 0);
