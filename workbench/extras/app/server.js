// Refuses a file that is too large before it is read: the server would only close the connection.
const LARGEST = 5e6;  // bytes
addEventListener("input", (event) => {
  const field = event.composedPath()[0];
  const size = [...(field.files ?? [])].reduce((sum, file) => sum + file.size, 0);
  if (size <= LARGEST || field.matches(".filepond--browser")) return;  // that one sends parts
  field.value = "";
  alert(`A file must not exceed ${LARGEST / 1e6} MB: is this the right one?`);
}, true);
