// A click on a picture shows it in its full size; Escape, the button or another click closes it.
const large = document.getElementById("large"), shown = new Image();
large.append(shown);
for (const button of document.querySelectorAll(".enlarge")) {
  button.addEventListener("click", () => {
    const picture = button.querySelector("img");
    shown.src = picture.src; shown.alt = picture.alt; large.showModal();
  });
}
large.addEventListener("click", () => large.close());
