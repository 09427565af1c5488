// Runs the Khronos glTF validator over every .glb and .gltf of a folder: node validate.mjs FOLDER.
// Prints each error, and how many files it saw. Exit code: 0 if there is no error, else 1.
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import validator from 'gltf-validator';

const kError = 0;  // severity; warnings are 1, notes 2 and 3

async function errorsOf(file) {
  const read = (path) => new Uint8Array(readFileSync(path));
  const report = await validator.validateBytes(read(file), {
    uri: file,
    maxIssues: 0,
    externalResourceFunction: async (uri) => read(join(dirname(file), decodeURIComponent(uri))),
  });
  return report.issues.messages.filter((issue) => issue.severity === kError);
}

const folder = process.argv[2];
const files = readdirSync(folder).filter((name) => /\.(glb|gltf)$/.test(name)).sort();
let failed = false;
for (const name of files) {
  const errors = await errorsOf(join(folder, name));
  for (const error of errors.slice(0, 20)) {
    console.log(`${name}: ${error.code} at ${error.pointer ?? error.offset}: ${error.message}`);
  }
  if (errors.length > 20) console.log(`${name}: ${errors.length - 20} more errors`);
  failed ||= errors.length > 0;
}
console.log(`${files.length} files`);
process.exitCode = failed ? 1 : 0;
