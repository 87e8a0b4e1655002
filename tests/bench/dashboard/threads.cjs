// What the operating system says of processes and their threads.

const { execFileSync } = require("node:child_process");
const { readFileSync, readdirSync } = require("node:fs");

const SCHED_FIFO = 1;
const fieldsOf = (path) => readFileSync(path, "utf8").split(") ")[1].split(" "); // from the third one, "state"

/// Process id of a child of `parent` by the first 15 letters of its name.
function child(parent, name) {
  const list = execFileSync("ps", ["-o", "pid=,comm=", "--ppid", String(parent)], { encoding: "utf8" });
  return Number(list.split("\n").find((line) => line.includes(name)).trim().split(/\s+/)[0]);
}

const megabytes = (pid, key) => Number(/(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8").split(key)[1])[1]) / 1024;

function cpuSeconds(pid) {
  const fields = fieldsOf(`/proc/${pid}/stat`);
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

/// The thread with SCHED_FIFO: the rig's loop. Undefined where there is none.
function realtimeThread(pid) {
  return readdirSync(`/proc/${pid}/task`).find((thread) => Number(fieldsOf(`/proc/${pid}/task/${thread}/stat`)[38]) === SCHED_FIFO);
}

/// ns that a thread was ready to run and another one ran.
const waited = (pid, thread) => Number(readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "utf8").split(" ")[1]);

const keepOn = (processor, thread) => execFileSync("taskset", ["-cp", String(processor), String(thread)]);

module.exports = { child, megabytes, cpuSeconds, keepOn, realtimeThread, waited };
