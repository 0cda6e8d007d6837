"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { axes, measures, sequences, rows } = data;

  // An element with attributes and children.
  const element = (name, attributes = {}, ...children) => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children);
    return made;
  };

  // A labelled choice of [value, text] that calls `changed`.
  const choice = (label, options, changed) => {
    const select = element("select", {}, ...options.map(([value, text]) => element("option", { value }, text)));
    select.addEventListener("change", changed);
    return [element("label", {}, label, select), select];
  };

  // The index of each axis's value in a combination; the last axis changes fastest.
  const indices = (combination) => {
    const at = [];
    for (const { values } of [...axes].reverse()) {
      at.unshift(combination % values.length);
      combination = Math.floor(combination / values.length);
    }
    return at;
  };
  const settings = (combination) =>
    indices(combination).map((at, axis) => `${axes[axis].name}=${axes[axis].values[at]}`).join(" ");

  // Makes the headers of a table sort its lines. `key` gives what line `line` is sorted by in column `column`, null without
  // a value; `show` gets the indices of the lines in their new order.
  const collator = new Intl.Collator(undefined, { numeric: true });
  const compare = (a, b) =>
    typeof a === "number" && typeof b === "number" ? a - b : collator.compare(String(a), String(b));
  const makeSortable = (table, count, key, show) => {
    const headers = [...table.tHead.rows[0].cells].filter((header) => !("unsorted" in header.dataset));
    const order = Array.from({ length: count }, (_, line) => line);
    const sort = (header) => {
      const now = header.getAttribute("aria-sort");
      // The best is on top first.
      const first = "more" in header.dataset ? "descending" : "ascending";
      const direction = now === "none" ? first : now === "ascending" ? "descending" : "ascending";
      for (const other of headers) other.setAttribute("aria-sort", "none");
      header.setAttribute("aria-sort", direction);
      const sign = direction === "ascending" ? 1 : -1;
      const keys = order.map((_, line) => key(line, header.cellIndex));
      order.sort((a, b) => {
        // Lines without a value are last in either order.
        if (keys[a] === null || keys[b] === null) return (keys[a] === null) - (keys[b] === null) || a - b;
        return sign * compare(keys[a], keys[b]) || a - b;
      });
      show(order);
    };
    for (const header of headers) {
      const button = element("button", { type: "button" }, ...header.childNodes);
      button.addEventListener("click", () => sort(header));
      header.replaceChildren(button);
      header.setAttribute("aria-sort", "none");
    }
    return order;
  };
  const keyOf = (text) => (text !== "" && isFinite(text) ? Number(text) : text);

  // Tables that are sorted by what their cells show. The line of a mean stays last.
  for (const table of document.querySelectorAll("table.sortable:not(#rows)")) {
    const all = [...table.tBodies].flatMap((body) => [...body.rows]);
    const lines = all.filter((line) => !line.matches(".group, .total"));
    const last = all.filter((line) => line.matches(".total"));
    const key = (line, column) => {
      const text = lines[line].cells[column].textContent.trim();
      return text === "\u2013" ? null : keyOf(text.replace("\u2212", "-"));
    };
    makeSortable(table, lines.length, key, (order) => {
      const body = element("tbody", {}, ...order.map((line) => lines[line]), ...last);
      for (const other of [...table.tBodies]) other.remove();
      table.append(body);
      table.classList.add("flat");
    });
  }

  // A line beside the first column while others are under it.
  for (const place of document.querySelectorAll(".scroll")) {
    place.addEventListener("scroll", () => place.classList.toggle("scrolled", place.scrollLeft > 0), { passive: true });
  }

  // The table of all rows: headers sort, a choice filters.
  const table = document.getElementById("rows");
  const [body, rest] = table.tBodies;
  const lines = [...body.rows, ...(rest ? rest.rows : [])];
  if (rest) rest.remove();
  const columnCount = table.tHead.rows[0].cells.length;
  // A table of thousands of rows is slow to lay out, so the first ones are shown until all are asked for.
  let limit = 200;
  let chosen = "";
  const at = rows.map(([, combination]) => indices(combination));
  const order = makeSortable(table, rows.length, (row, column) => {
    const [sequence, , values, seconds] = rows[row];
    if (column === 0) return sequences[sequence];
    if (column <= axes.length) return keyOf(axes[column - 1].values[at[row][column - 1]]);
    return column === columnCount - 1 ? seconds : values[column - 1 - axes.length];
  }, () => show());
  const more = element("button", { type: "button", class: "more" });
  const show = () => {
    const matching = order.filter((row) => chosen === "" || rows[row][0] === Number(chosen));
    body.replaceChildren(...matching.slice(0, limit).map((row) => lines[row]));
    const hidden = matching.length > limit;
    table.caption.textContent = `${hidden ? `${limit} of ` : ""}${matching.length} row${matching.length === 1 ? "" : "s"}`;
    more.textContent = `Show all ${matching.length} rows`;
    more.hidden = !hidden;
  };
  more.addEventListener("click", () => {
    limit = Infinity;
    show();
  });
  document.getElementById("all").append(more);
  if (sequences.length > 1) {
    const options = [["", "all sequences"], ...sequences.map((name, index) => [index, name])];
    const [label, select] = choice("Sequence", options, () => {
      chosen = select.value;
      show();
    });
    document.querySelector("#all .controls").append(label);
  }
  show();

  // The heat maps.
  const place = document.getElementById("map");
  if (place) {
    const mapped = measures.map((measure, column) => ({ ...measure, column })).filter((m) => m.mapped !== null);
    mapped.sort((a, b) => a.mapped - b.mapped);
    const byKey = new Map(rows.map((row) => [`${row[0]} ${row[1]}`, row]));
    const combinations = data.overall.length;

    const draw = () => {
      const measure = mapped[measureChoice.value];
      const sequence = sequenceChoice ? sequenceChoice.value : "";
      const axisAt = data.maps[mapChoice.value];
      const [across, down] = axisAt.map((axis) => axes[axis] ?? null);
      const value = (combination) =>
        sequence === "" ? data.overall[combination][measure.mapped]
          : byKey.get(`${sequence} ${combination}`)?.[2][measure.column] ?? null;
      const better = (a, b) => (measure.more ? a > b : a < b);
      const columns = across.values.length;
      const cells = Array(columns * (down ? down.values.length : 1)).fill(null);
      for (let combination = 0; combination < combinations; combination++) {
        const found = value(combination);
        if (found === null) continue;
        const index = indices(combination);
        const cell = (down ? index[axisAt[1]] * columns : 0) + index[axisAt[0]];
        if (cells[cell] === null || better(found, cells[cell].value)) cells[cell] = { value: found, combination };
      }
      let best = null;
      let worst = null;
      for (const cell of cells) {
        if (cell && (!best || better(cell.value, best.value))) best = cell;
        if (cell && (!worst || better(worst.value, cell.value))) worst = cell;
      }
      const text = (value) => value.toFixed(measure.decimals === 1 && Number.isInteger(value) ? 0 : measure.decimals);
      const coloured = (cell) => {
        if (!cell) return element("td", { class: "missing" });
        // As in `HeatMap::share`: a small difference is no contrast.
        const span = Math.max(Math.abs(best.value - worst.value), 0.05 * Math.max(Math.abs(best.value), Math.abs(worst.value)));
        const share = span === 0 ? 1 : 1 - Math.abs(best.value - cell.value) / span;
        const [colour, dark] = data.ramp[Math.round(share * (data.ramp.length - 1))];
        const drawn = element("td", { title: settings(cell.combination) }, text(cell.value).replace("-", "\u2212"));
        drawn.style.background = colour;
        drawn.style.color = dark ? "#000" : "#fff";
        if (cell === best) drawn.className = "best";
        return drawn;
      };
      const open = axes.filter((axis) => axis !== across && axis !== down && axis.values.length > 1);
      const names = open.map((axis) => axis.title);
      const last = names.pop();
      const over = last ? `best over ${names.length ? `${names.join(", ")} and ${last}` : last}` : "";
      const subject = sequence === "" ? "all sequences" : sequences[sequence];
      const head = element("thead", {},
        element("tr", {}, element("td"), element("th", { scope: "colgroup", colspan: columns }, across.title)),
        element("tr", {}, element("th", { scope: "col" }, down ? down.title : ""),
          ...across.values.map((text) => element("th", { scope: "col" }, text))));
      const lines = (down ? down.values : [""]).map((label, row) =>
        element("tr", {}, element("th", { scope: "row" }, label),
          ...cells.slice(row * columns, (row + 1) * columns).map(coloured)));
      place.replaceChildren(element("table", { class: "map" },
        element("caption", {}, `${measure.label}, ${subject}`, element("span", {}, over)), head,
        element("tbody", {}, ...lines)));
    };

    const controls = document.querySelector("#maps .controls");
    let sequenceChoice = null;
    if (sequences.length > 1) {
      const options = [["", "all sequences"], ...sequences.map((name, index) => [index, name])];
      let label;
      [label, sequenceChoice] = choice("Sequence", options, draw);
      controls.append(label);
    }
    const [measureLabel, measureChoice] = choice("Measure", mapped.map((m, index) => [index, m.label]), draw);
    const title = ([across, down]) => (down === null ? axes[across].title : `${axes[across].title} × ${axes[down].title}`);
    const [mapLabel, mapChoice] = choice("Settings", data.maps.map((map, index) => [index, title(map)]), draw);
    controls.append(measureLabel, mapLabel);
  }

  // Number and value of the frame under the pointer, or chosen with the arrow keys.
  for (const figure of document.querySelectorAll(".curve")) {
    const { numbers, values } = data.curves[figure.dataset.curve];
    const area = figure.querySelector(".area");
    const output = figure.querySelector("output");
    const dot = element("i");
    const cursor = element("div", { class: "cursor" }, dot);
    const first = numbers[0];
    const last = numbers[numbers.length - 1];
    let index = 0;
    const show = (next) => {
      index = Math.min(Math.max(next, 0), numbers.length - 1);
      const share = last > first ? (numbers[index] - first) / (last - first) : 0.5;
      cursor.style.left = `${100 * share}%`;
      dot.style.top = `${100 * (1 - values[index])}%`;
      output.textContent = `frame ${numbers[index]}: ${values[index].toFixed(3)}`;
      area.append(cursor);
    };
    const hide = () => {
      cursor.remove();
      output.textContent = "";
    };
    area.addEventListener("pointermove", (event) => {
      const box = area.getBoundingClientRect();
      const wanted = first + ((event.clientX - box.left) / box.width) * (last - first);
      let low = 0;
      let high = numbers.length - 1;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (numbers[middle] < wanted) low = middle + 1;
        else high = middle;
      }
      show(low > 0 && wanted - numbers[low - 1] < numbers[low] - wanted ? low - 1 : low);
    });
    area.addEventListener("pointerleave", hide);
    area.tabIndex = 0;
    area.setAttribute("role", "group");
    area.setAttribute("aria-label", "Values by frame; the arrow keys move");
    area.addEventListener("focus", () => show(index));
    area.addEventListener("blur", hide);
    area.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10, Home: -Infinity, End: Infinity }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      show(index + step);
    });
  }
})();
