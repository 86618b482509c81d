// The module in Node, by the protocol of rust/wasm/examples/native.rs: node wasm_in_node.js ENGINE WASM
"use strict";

const { readFileSync } = require("node:fs");
const [engineFile, wasmFile] = process.argv.slice(2);
require(engineFile);

const numberOf = (digits) => {
  const view = new DataView(new ArrayBuffer(8));
  view.setBigUint64(0, BigInt(`0x${digits}`));
  return view.getFloat64(0);
};
const digitsOf = (numbers) => {
  const bits = new BigUint64Array(numbers.buffer, numbers.byteOffset, numbers.length);
  return Array.from(bits, (each) => each.toString(16).padStart(16, "0")).join(" ");
};

async function main() {
  const engine = await popsteer.Engine.load(readFileSync(wasmFile));
  const answers = [];
  for (const line of readFileSync(0, "utf-8").trimEnd().split("\n")) {
    const [call, ...digits] = line.split(" ");
    const numbers = digits.map(numberOf);
    try {
      if (call === "open" || call === "closed") {
        engine.setTrack(numbers, call === "closed");
        answers.push("");
      } else if (call === "draw") {
        answers.push(digitsOf(engine.draw(numbers).waypoints));
      } else {
        const named = Object.fromEntries(engine.settings.map((name, index) => [name, numbers[index]]));
        const { metrics, rows } = engine.drive(call, named);
        answers.push(`${digitsOf(Float64Array.from(Object.values(metrics)))} ${digitsOf(rows)}`);
      }
    } catch (error) {
      if (!(error instanceof popsteer.Refused)) throw error;
      answers.push(error.message);
    }
  }
  process.stdout.write(`${answers.join("\n")}\n`);
}

main();
