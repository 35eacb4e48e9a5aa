import { Problem, createProgramme, readProgramme, replaceProgramme, type Fault, type JsonObject } from './api.ts';
import { ask, type Line } from './dialog.ts';
import { inWorld, readTags, toProgramme } from './library.ts';
import { NAME, slug } from './text.ts';

/** What the user says about a programme. */
interface Said {
  title: string;
  name: string;
  tags: string;
}

/** Which line each of the library document's own faults belongs to. */
type Place = 'title' | 'name' | 'tags';
type Errors = Partial<Record<Place, string>>;

function linesOf(said: Said, follows: boolean, errors: Errors): Line[] {
  const error = (line: Place) => (errors[line] ? { error: errors[line] } : {});
  return [
    { label: 'Title', value: said.title, optional: true, ...error('title') },
    { label: 'Name', value: said.name, ...NAME, ...(follows ? { follow: slug } : {}), ...error('name') },
    { label: 'Tags', value: said.tags, optional: true, hint: 'Such as: mountains, alpine', ...error('tags') },
  ];
}

/** The faults that stand in this dialog; the others belong to the form. */
function ownErrors(faults: readonly Fault[]): Errors | undefined {
  const errors: Errors = {};
  for (const { pointer, detail } of faults) {
    const line = pointer.split('/')[1];
    if (line !== 'title' && line !== 'tags') return undefined;
    errors[line] = [errors[line], detail].filter(Boolean).join('. ');
  }
  return faults.length > 0 ? errors : undefined;
}

/** Saves over the programme of that name; its description stays, and its tags where no others were given. */
async function replace(name: string, document: JsonObject, tags: readonly string[]): Promise<void> {
  const { document: old, etag } = await readProgramme(name);
  const { description, tags: oldTags } = old;
  const kept = { ...(description === undefined ? {} : { description }), ...(tags.length > 0 || oldTags === undefined ? {} : { tags: oldTags }) };
  await replaceProgramme(name, { ...document, ...kept }, etag);
}

/**
 * Asks for title, name and tags, and saves the programme of a world to the library; resolves to its name.
 * What is wrong with the programme itself is thrown, at its place in the world.
 */
export async function saveProgramme(world: JsonObject, origin: string): Promise<string | undefined> {
  const title = typeof world['title'] === 'string' ? world['title'] : '';
  let said: Said = { title, name: slug(title), tags: '' };
  let errors: Errors = {};
  for (;;) {
    const reply = await ask({
      title: 'Save the programme to the library',
      text: 'With its scale, heights and seed, so that other worlds can be made from it.',
      lines: linesOf(said, !said.name || said.name === slug(said.title), errors),
      answers: [
        { id: 'cancel', label: 'Cancel' },
        ...(errors.name ? [{ id: 'replace', label: 'Replace it' } as const] : []),
        { id: 'save', label: 'Save', primary: true },
      ],
    });
    if (!reply || reply.answer === 'cancel') return undefined;
    const [title = '', name = '', tags = ''] = reply.texts;
    said = { title, name, tags };
    try {
      const read = readTags(tags);
      const document = { ...toProgramme(world), ...(title ? { title } : {}), tags: read, origin };
      if (reply.answer === 'replace') await replace(name, document, read);
      else await createProgramme(name, document);
      return name;
    } catch (problem) {
      if (!(problem instanceof Problem)) throw problem;
      const own = problem.status === 409 ? { name: problem.message } : ownErrors(problem.faults);
      if (!own) throw new Problem(problem.status, problem.message, problem.faults.map(inWorld));
      errors = own;
    }
  }
}
