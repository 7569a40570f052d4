declare module '*.pith' { const document: { [key: string]: any }; export default document; }
declare module '*.glsl' { const text: string; export default text; }
declare module '*.svg' { const text: string; export default text; }
