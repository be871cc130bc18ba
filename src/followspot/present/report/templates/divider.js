// Pairs of pictures: one over the other, with a divider. The range input is what the keyboard and
// screen readers move; a pointer anywhere on the pictures sets it too.
for (const pair of document.querySelectorAll(".pair")) {
  const labels = [...pair.querySelectorAll(".label")].map((label) => label.textContent);
  const range = document.createElement("input");
  range.type = "range";
  range.step = "any";
  range.value = 50;
  range.setAttribute("aria-label", `Divider between ${labels[0]} and ${labels[1]}`);
  const show = () => {
    pair.style.setProperty("--cut", `${range.value}%`);
    const share = Math.round(range.value);
    range.setAttribute("aria-valuetext", `${share} % ${labels[0]}, ${100 - share} % ${labels[1]}`);
  };
  const follow = (event) => {
    const box = pair.getBoundingClientRect();
    range.value = ((event.clientX - box.left) / box.width) * 100;
    show();
  };
  pair.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    range.focus({ preventScroll: true, focusVisible: false });
    pair.setPointerCapture(event.pointerId);
    follow(event);
  });
  pair.addEventListener("pointermove", (event) => {
    if (pair.hasPointerCapture(event.pointerId)) follow(event);
  });
  range.addEventListener("input", show);
  const line = document.createElement("span");
  line.className = "line";
  pair.append(range, line);
  pair.classList.add("live");
  show();
}
