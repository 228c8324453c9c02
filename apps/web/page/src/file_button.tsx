// A button that opens a file.

interface Props {
  words: string;
  accept: string;
  onFile(file: File): void;
}

export function FileButton({ words, accept, onFile }: Props) {
  return (
    <label class="button">
      {words}
      <input
        type="file"
        class="hidden"
        accept={accept}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) onFile(file);
          // The same file may be opened again.
          event.currentTarget.value = "";
        }}
      />
    </label>
  );
}
