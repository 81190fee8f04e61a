const dialog = document.getElementById("enlarged"), large = dialog.querySelector("img");
for (const button of document.querySelectorAll("button.zoom")) {
  button.addEventListener("click", () => {
    const { src, alt } = button.querySelector("img");
    Object.assign(large, { src, alt });
    dialog.showModal();
  });
}
dialog.addEventListener("click", () => dialog.close());
