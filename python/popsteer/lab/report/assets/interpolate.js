// Where everything is at a place of the cursor.

// The last sample at or before `value`, and how far towards the next one it is.
function sampleAt(axis, value) {
  let low = 0, high = axis.length - 1;
  if (!(value > axis[0])) return [0, 0];
  if (value >= axis[high]) return [high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (axis[middle] <= value) low = middle; else high = middle;
  }
  const width = axis[high] - axis[low];
  return [low, width > 0 ? (value - axis[low]) / width : 0];
}

function between(column, [k, part]) {
  if (!column) return NaN;
  const here = column[k];
  if (!(part > 0)) return here;
  const next = column[k + 1];
  return Number.isFinite(next) && Number.isFinite(here) ? here + part * (next - here) : here;
}

function angleBetween(column, [k, part]) {
  if (!column) return NaN;
  if (!(part > 0)) return column[k];
  const turn = column[k + 1] - column[k];
  return column[k] + part * Math.atan2(Math.sin(turn), Math.cos(turn));
}

// The actor's time or distance where the other one is `value`.
function converted(actor, from, to, value) {
  return between(actor.columns[to], sampleAt(actor.columns[from], value));
}
