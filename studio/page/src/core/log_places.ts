// Places in files that lines of the log name.

export interface LogPlace {
  file: string;
  line: number;
  column: number;
}

/** The first place of the form FILE:LINE or FILE:LINE:COLUMN whose file is one of those below the folder. */
export function placeIn(text: string, folder: string, files: ReadonlySet<string>): LogPlace | undefined {
  for (const found of text.matchAll(/([^\s'"]+?):(\d+)(?::(\d+))?(?=\D|$)/g)) {
    const [, path, line, column] = found;
    const file = path!.startsWith(`${folder}/`) ? path!.slice(folder.length + 1) : path!;
    if (files.has(file)) return { file, line: Number(line), column: Number(column ?? 1) };
  }
  return undefined;
}
